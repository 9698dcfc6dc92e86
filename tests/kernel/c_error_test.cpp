// dvdx.h: refusals, their messages, and freedom from leaks.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "dvdx/dvdx.h"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/c_handles.hpp"

namespace c_handles::error_test {

TEST_CASE("c: an error names the field, the value and the range, and changes nothing") {
  Handles h;
  dvdx_spring spring{};
  spring.stiffness.all = -40;
  CHECK(dvdx_scene_add_spring(h.scene, &spring, &h.error) == DVDX_DONE);
  CHECK(h.make(options_of(0.01)) == DVDX_INVALID);
  CHECK(h.plan == nullptr);
  CHECK(h.message() == "forces[0].stiffness is -40: must be a finite number >= 0");
  CHECK(h.field() == "forces[0].stiffness");
  CHECK(std::string(&h.error.value[0]) == "-40");
  CHECK(std::string(&h.error.valid[0]) == "a finite number >= 0");
  CHECK(dvdx_plan_create(h.scene, nullptr, nullptr, &h.plan, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "options");
  CHECK(h.make(options_of(0.01), nullptr) == DVDX_INVALID);
  dvdx_options options = options_of(0.01);
  options.isa = static_cast<dvdx_isa>(7);
  CHECK(h.make(options) == DVDX_INVALID);
  CHECK(h.field() == "isa");
}

TEST_CASE("c: choices that do not exist and null pointers are refused at once") {
  Handles h;
  dvdx_drag drag{};
  drag.method = static_cast<dvdx_method>(7);
  CHECK(dvdx_scene_add_drag(h.scene, &drag, &h.error) == DVDX_INVALID);
  CHECK(h.message() == "forces[0].method is 7: must be a choice from 0 to 5");
  CHECK(dvdx_scene_add_drag(h.scene, nullptr, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "forces");
  CHECK(dvdx_scene_add_drag(nullptr, &drag, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "scene");
  dvdx_springs springs{};
  springs.count = 2;
  CHECK(dvdx_scene_add_springs(h.scene, &springs, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "networks[0].pairs");
  CHECK(dvdx_scene_set_fixed(h.scene, nullptr, 2, &h.error) == DVDX_INVALID);
  CHECK(dvdx_scene_set_mass(h.scene, nullptr, nullptr) == DVDX_INVALID);  // no error object
  dvdx_scene* other = nullptr;
  CHECK(dvdx_scene_create(DVDX_ABI_VERSION + 1, &other, &h.error) == DVDX_ABI_DIFFERS);
  CHECK(other == nullptr);
  CHECK(h.message() == dvdx_status_text(DVDX_ABI_DIFFERS));
}

// Allocates until its limit, and counts the blocks in use.
struct Heap {
  long left;
  long out = 0, most = 0;
  static void* allocate(void* context, std::size_t bytes, std::size_t alignment) {
    auto& heap = *static_cast<Heap*>(context);
    if (heap.left-- <= 0) return nullptr;
    heap.most = std::max(heap.most, ++heap.out);
    return std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  }
  static void release(void* context, void* memory, std::size_t /*bytes*/, std::size_t /*alignment*/) {
    --static_cast<Heap*>(context)->out;
    std::free(memory);
  }
};

TEST_CASE("c: wherever the allocator has no memory left, making a plan fails and leaks nothing") {
  Handles h;
  add_forces(h);
  add_joints(h);
  Arrays<float> arrays(6);
  const dvdx_state state = arrays.c();
  for (long given = 0;; ++given) {
    REQUIRE(given < 1000);
    Heap heap{given};
    dvdx_options options = options_of(1.0 / 60);
    options.allocator = {Heap::allocate, Heap::release, &heap};
    const dvdx_status status = h.make(options, &state);
    if (status == DVDX_DONE) {
      CHECK(given > 5);
      CHECK(heap.out == given);
      // A change that fails for lack of memory leaks nothing either, and the plan steps on unchanged.
      heap.left = 0;
      CHECK(dvdx_plan_set_step(h.plan, 0.01, &h.error) == DVDX_OUT_OF_MEMORY);
      CHECK(dvdx_plan_replace(h.plan, 0, h.scene, 0, &h.error) == DVDX_OUT_OF_MEMORY);
      CHECK(heap.out == given);
      dvdx_state moving = arrays.c();
      CHECK(dvdx_plan_step(h.plan, &moving, 1, nullptr, &h.error) == DVDX_DONE);
      dvdx_plan_destroy(h.plan);
      h.plan = nullptr;
      CHECK(heap.out == 0);
      return;
    }
    CHECK(status == DVDX_OUT_OF_MEMORY);
    CHECK(h.plan == nullptr);
    CHECK(heap.out == 0);
  }
}

}  // namespace c_handles::error_test
