// The numbers that a state's next step depends on beside its columns and its clock, written and read back.
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "compile/checker.hpp"
#include "execute/plan_parts.hpp"

namespace dvdx {
namespace {

class NumbersOut {
 public:
  void operator()(const double& number) { numbers.push_back(number); }
  void operator()(const bool& flag) { numbers.push_back(flag ? 1 : 0); }

  std::vector<double> numbers;
};

class NumbersIn {
 public:
  explicit NumbersIn(std::span<const double> numbers) : numbers_(numbers) {}

  void operator()(double& number) { number = next(); }
  void operator()(bool& flag) {
    const double number = next();
    is_right_ = is_right_ && (number == 0 || number == 1);
    flag = number == 1;
  }
  [[nodiscard]] bool has(std::size_t count) const noexcept { return numbers_.size() - used_ >= count; }
  [[nodiscard]] bool is_used_up() const noexcept { return is_right_ && used_ == numbers_.size(); }

 private:
  double next() {
    if (used_ < numbers_.size()) return numbers_[used_++];
    is_right_ = false;
    return 0;
  }

  std::span<const double> numbers_;
  std::size_t used_ = 0;
  bool is_right_ = true;
};

// Everything that is driven, in the order in which both ways pass it.
template <class Archive, class A>
void pass_driven(Archive& archive, std::vector<DrivenMotion>& motions, std::vector<DrivenPlaces>& groups,
                 std::vector<DrivenSkin>& skins, const A& has) {
  for (DrivenMotion& motion : motions) motion.pass(archive);
  for (DrivenPlaces& group : groups) group.pass(archive, has);
  for (DrivenSkin& skin : skins) skin.pass(archive);
}

template <class T, class A>
std::vector<double> carried_in(const JoinedMotion<A>* joined, JoinedWorkspace<A>* workspace, const State<T>& state) {
  if (joined == nullptr || workspace == nullptr || !workspace->fits(joined->shape())) return {};
  NumbersOut out;
  const auto& a = workspace->work.a;
  const bool is_whose = state.count == joined->joints().particles() && workspace->remembers(state.x[0].base, state.clock);
  const bool remembers = a[0] != nullptr && is_whose;
  out(remembers);
  if (remembers) {
    std::vector<double> accelerations(3 * state.count);
    joined->joints().order.for_each([&](std::size_t element, std::size_t particle) {
      for (std::size_t axis = 0; axis < 3; ++axis) accelerations[3 * particle + axis] = static_cast<double>(a[axis][element]);
    });
    out.numbers.insert(out.numbers.end(), accelerations.begin(), accelerations.end());
  }
  pass_driven(out, workspace->motions, workspace->groups, workspace->skins, [](std::size_t) { return true; });
  return std::move(out.numbers);
}

Error not_of_this_plan(std::span<const double> carried) {
  return {"carried", std::to_string(carried.size()) + " numbers", "what carried() gave of a plan of the same scene and state"};
}

// All or nothing.
template <class T, class A>
Expected<void> restore_in(const JoinedMotion<A>* joined, JoinedWorkspace<A>* workspace, std::span<const double> carried,
                          const State<T>& state) {
  if (joined == nullptr || workspace == nullptr || !workspace->fits(joined->shape())) {
    if (joined == nullptr && carried.empty()) return {};
    return tl::unexpected(not_of_this_plan(carried));
  }
  NumbersIn in(carried);
  bool remembers = false;
  in(remembers);
  const auto& a = workspace->work.a;
  const std::size_t particles = joined->joints().particles();
  if (state.count != particles || (remembers && (a[0] == nullptr || !in.has(3 * particles)))) {
    return tl::unexpected(not_of_this_plan(carried));
  }
  std::vector<double> accelerations(remembers ? 3 * particles : 0);
  for (double& number : accelerations) in(number);
  auto motions = workspace->motions;
  auto groups = workspace->groups;
  auto skins = workspace->skins;
  pass_driven(in, motions, groups, skins, [&](std::size_t numbers) { return in.has(numbers); });
  if (!in.is_used_up()) return tl::unexpected(not_of_this_plan(carried));
  workspace->motions = std::move(motions);
  workspace->groups = std::move(groups);
  workspace->skins = std::move(skins);
  workspace->known = workspace->all_known;
  workspace->forget();
  if (!remembers) return {};
  for (A* const column : a) std::fill_n(column, joined->joints().order.size, A(0));
  joined->joints().order.for_each([&](std::size_t element, std::size_t particle) {
    for (std::size_t axis = 0; axis < 3; ++axis) a[axis][element] = static_cast<A>(accelerations[3 * particle + axis]);
  });
  workspace->remember(state.x[0].base, state.clock);
  return {};
}

}  // namespace

template <class T>
std::vector<double> Plan<T>::carried(const State<T>& state) const {
  if (parts_ == nullptr) return {};
  return std::visit([&](const auto& in) { return carried_in(in.scene->joined(), in.workspace.get(), state); }, parts_->in);
}

template <class T>
std::vector<double> Plan<T>::carried(const State<T>& state, const Workspace<T>& workspace) const {
  if (parts_ == nullptr || workspace.parts_ == nullptr) return {};
  const auto of = [&]<class A>(const PlanIn<A>& in) {
    const auto* given = std::get_if<std::unique_ptr<JoinedWorkspace<A>>>(&workspace.parts_->in);
    return carried_in(in.scene->joined(), given != nullptr ? given->get() : nullptr, state);
  };
  return std::visit(of, parts_->in);
}

template <class T>
Expected<void> Plan<T>::restore(std::span<const double> carried, const State<T>& state) {
  const auto into = [&](auto& in) { return restore_in(in.scene->joined(), in.workspace.get(), carried, state); };
  return changed(parts_, "plan", into);
}

template <class T>
Expected<void> Plan<T>::restore(std::span<const double> carried, const State<T>& state, Workspace<T>& workspace) const {
  if (workspace.parts_ == nullptr) return tl::unexpected(moved_from("workspace"));
  const auto into = [&]<class A>(const PlanIn<A>& in) {
    const auto* given = std::get_if<std::unique_ptr<JoinedWorkspace<A>>>(&workspace.parts_->in);
    return restore_in(in.scene->joined(), given != nullptr ? given->get() : nullptr, carried, state);
  };
  return changed(parts_, "plan", into);
}

template std::vector<double> Plan<float>::carried(const State<float>&) const;
template std::vector<double> Plan<double>::carried(const State<double>&) const;
template std::vector<double> Plan<float>::carried(const State<float>&, const Workspace<float>&) const;
template std::vector<double> Plan<double>::carried(const State<double>&, const Workspace<double>&) const;
template Expected<void> Plan<float>::restore(std::span<const double>, const State<float>&);
template Expected<void> Plan<double>::restore(std::span<const double>, const State<double>&);
template Expected<void> Plan<float>::restore(std::span<const double>, const State<float>&, Workspace<float>&) const;
template Expected<void> Plan<double>::restore(std::span<const double>, const State<double>&, Workspace<double>&) const;

}  // namespace dvdx
