// The states after some steps of every kind of scene, hashed. They must be the same on every machine, with every compiler and
// at every level of optimisation, or else coefficients depend on the build.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"

namespace golden_test {

using namespace dvdx;

// Where a change of the arithmetic is meant, the test's message has the new numbers.
constexpr std::uint64_t golden_separate = 15184788198911441522U;
constexpr std::uint64_t golden_contracted = 14901867960843675406U;
constexpr std::uint64_t golden_networks = 2030490220018824651U;

// The cases that the three above leave out: a line each, so that a change shows what it changes. Compensated states and
// particles that come and go have no contracted form: 0.
struct Golden {
  std::string_view name;
  std::uint64_t separate, contracted;
};
constexpr Golden golden_cases[] = {
    {"contact: plane, resume, curve", 0xC9DBEC223FC0C6D4, 0x9EE8E1A09A3DC1DB},
    {"contact: plane, resume, line", 0xB29E4D65873C68AE, 0x07EB71A8CDE90406},
    {"contact: plane, seed, curve", 0x62809C04C90BD6CE, 0xF90581F9D4393D82},
    {"contact: plane, seed, line", 0x6A19ACF6ECBFCFA8, 0x29B0879B536A1184},
    {"contact: sphere, resume, curve", 0xB617D16675C6CC46, 0x896FBE713D5D8CCD},
    {"contact: sphere, resume, line", 0x5AB33BF88B7DEFC7, 0x0AEB8EAC8D0C17FA},
    {"contact: sphere, seed, curve", 0x7B3CAFED23507CB4, 0x3F12C7CB6CA90EF3},
    {"contact: sphere, seed, line", 0xFA3A49977217796D, 0x8FD9966B89098418},
    {"contact: inside a sphere, resume, curve", 0x4C486561E3AC90F9, 0xC9A8A4666E17B9A4},
    {"contact: inside a sphere, resume, line", 0x1D06439028884B66, 0xD42E13BFEA80B902},
    {"contact: inside a sphere, seed, curve", 0x9D96FCD00F4D7FEF, 0xB3D185960F0D4A1E},
    {"contact: inside a sphere, seed, line", 0x83C8AAB3B1AC9626, 0xE4D5A677D82BF9D5},
    {"contact: capsule, resume, curve", 0xDE081C088B42FA50, 0xD4F146B3765C0A9B},
    {"contact: capsule, resume, line", 0xADD4E0EBB00BF08F, 0x526174230FE5A3A0},
    {"contact: capsule, seed, curve", 0x2FCE6027F21921DB, 0x1EFA91A21BA39B96},
    {"contact: capsule, seed, line", 0x244F7850BAD01239, 0x5FC09441A2D4C801},
    {"contact: box, resume, curve", 0xB38A87AAEF74F669, 0x069B36AB6C973639},
    {"contact: box, resume, line", 0x60A6AD5EB38D026F, 0x5776DBE37A769E82},
    {"contact: box, seed, curve", 0x6CA1A75961F7AEF7, 0x64FF9B5DF65D14BD},
    {"contact: box, seed, line", 0xF86DE235F1B5EE90, 0x1CB8F95759BECB26},
    {"contact: inside a box, resume, curve", 0x24F882DC859027A6, 0x6841240DD747D3A0},
    {"contact: inside a box, resume, line", 0xF2FBD3C5C3124866, 0x81B4D90EC8A50461},
    {"contact: inside a box, seed, curve", 0x923D20901B6C8FAB, 0xF4B9C816BBFDC130},
    {"contact: inside a box, seed, line", 0xA15F6D51E2894E39, 0x54365A56DBD6EA8B},
    {"contact: convex body, resume, curve", 0xC4EAB9147C805D5D, 0x2AF164492C005D04},
    {"contact: convex body, resume, line", 0xEB1CC53F60941AE8, 0x3DBB2422248BA56C},
    {"contact: convex body, seed, curve", 0x88EDE56798EE935C, 0x253B5B27E82A1A7B},
    {"contact: convex body, seed, line", 0x71E10A3E4F19EB0A, 0xC1567BCD7D6D5589},
    {"contact: mesh, resume, curve", 0x50739AFB2FCA78F8, 0xD43DB807C7D3A0A1},
    {"contact: mesh, resume, line", 0x0DB81FE51C95FD6B, 0x6299E53B01F7F873},
    {"contact: mesh, seed, curve", 0x5AED9B6F6251C685, 0x6A5E59EBB993ACD1},
    {"contact: mesh, seed, line", 0x681C1B48863897B3, 0x2F505E48F07BBAA4},
    {"contact: a corner of two planes and a sphere", 0xEE02DFF9536A20B1, 0x5C4530195A528514},
    {"contact: a ball and a box that push out", 0x0BB2FF110D90B783, 0x73620839F958FC36},
    {"radial springs: combined", 0x469C48FBE752C8CF, 0x9E0DA197B9BD98B9},
    {"radial springs: exact", 0x477009E4612E8E9F, 0x442B6904B079EBCA},
    {"radial springs: average acceleration", 0x3668570C4E8A8138, 0x93D7228F8FCD268C},
    {"radial springs: pulse", 0xE49932AF118716BF, 0x9B7FA0C669D154C4},
    {"radial springs: symplectic Euler", 0xEB47A7BE6424A515, 0xAE3617A07A09253B},
    {"accumulate: combined, midpoint", 0x977647D97FC03E57, 0x40B82D0B43E8DFD5},
    {"accumulate: exact, midpoint", 0x46504565458597D8, 0x6BC1B0C00C27A24C},
    {"accumulate: exact, start", 0x33EB2C7E3AA014E3, 0xF79EADA84802DE90},
    {"accumulate: average acceleration, midpoint", 0xF9EF37312DE802D4, 0xCE4768959F3326F6},
    {"accumulate: average acceleration, start", 0xC918E8EB6FF851F2, 0x25392BC953B7F7D0},
    {"accumulate: pulse, midpoint", 0x0A75B6610FE23060, 0xB1E8B173E52634D7},
    {"accumulate: pulse, start", 0x201DB0947EE9C316, 0x1D2254B68A4E2F7A},
    {"accumulate: symplectic Euler, midpoint", 0x632E6D5FB5EABEEA, 0x2398916A9FE4F601},
    {"accumulate: symplectic Euler, start", 0x1E7E9EEE95F16230, 0x22B457138BAF0B3D},
    {"springs: leapfrog, a grid", 0xC14EFC2DCFDFE7F5, 0x9D516E12D5E23A13},
    {"springs: leapfrog, a list", 0xC14EFC2DCFDFE7F5, 0x9D516E12D5E23A13},
    {"springs: leapfrog, a grid, and a rope that is damped", 0xD22F4F864431EE36, 0x6CFAF6461B7E9FB8},
    {"springs: leapfrog, a grid, damped", 0x482E3CD1D4E55517, 0x60E3354C5CA3B94B},
    {"springs: leapfrog, a list, damped", 0x482E3CD1D4E55517, 0x60E3354C5CA3B94B},
    {"springs: leapfrog, a grid and a rope, both damped", 0xD3FD29EE68F9908C, 0xF7B7C5BCAEDD6A22},
    {"springs: fourth order, a grid", 0x0CA2EE014EFDA965, 0x9A6E6DF7746A5EC4},
    {"springs: fourth order, a list", 0x0CA2EE014EFDA965, 0x9A6E6DF7746A5EC4},
    {"springs: fourth order, a grid, and a rope that is damped", 0x212A9994052FDF74, 0x270C09F4C89741CB},
    {"springs: fourth order, a grid, damped", 0x8D7A85D9E2716E66, 0x5A403CDBC134AFCB},
    {"springs: fourth order, a list, damped", 0x8D7A85D9E2716E66, 0x5A403CDBC134AFCB},
    {"springs: fourth order, a grid and a rope, both damped", 0xEBC29ADAC43AF73C, 0x37BCF0C252AF3C05},
    {"air: leapfrog, a grid", 0x3A51EA2526F698EA, 0xED87221F96981F82},
    {"air: leapfrog, a list", 0xB1FBBA1C934008AD, 0x729F86395CC8E415},
    {"air: leapfrog, a grid, damped", 0x8AE333470FBABAC2, 0xB967602BA06BFAEC},
    {"air: leapfrog, a list, damped", 0x626A70CABFF73A2A, 0x46AE517F925EBA14},
    {"air: fourth order, a grid", 0x1CF356BEF0EDF914, 0xB5AD10F60BEE4866},
    {"air: fourth order, a list", 0x4D93A8E9E191AAE0, 0x98BAEA93E6B05857},
    {"air: fourth order, a grid, damped", 0x9F106CC193AD0C07, 0xAA2FEC733126D0DE},
    {"air: fourth order, a list, damped", 0x052476694C2C6167, 0x3B11F6C73071FBA6},
    {"air: sequential, a grid", 0xB1E67C752386C288, 0x22A78FFCF24CF6C2},
    {"air: sequential, a list", 0xB1E67C752386C288, 0x22A78FFCF24CF6C2},
    {"air: sequential, a grid, damped", 0x3C62D6CECF8B1C28, 0xB2BE1220CC858FFC},
    {"air: sequential, a list, damped", 0x3C62D6CECF8B1C28, 0xB2BE1220CC858FFC},
    {"air: generalized alpha, a grid", 0x82CB8F07E407F30D, 0x34AE0792BEBEDEB3},
    {"air: generalized alpha, a list", 0x19DBB92B9A32629E, 0x91A69D90D1D1BD24},
    {"air: generalized alpha, a grid, damped", 0x3C8AC2F9E60841AE, 0x2B7AE86CCF938B72},
    {"air: generalized alpha, a list, damped", 0x445C4E5FE1AF9D88, 0xBDC08A6417499F61},
    {"air: accumulate, a grid", 0xAACE60562D39D123, 0x560F3B1A24B59728},
    {"air: accumulate, a list", 0xAACE60562D39D123, 0x560F3B1A24B59728},
    {"air: accumulate, a grid, damped", 0x130188A1667DCB7D, 0x09B002DD8BE9E57A},
    {"air: accumulate, a list, damped", 0x130188A1667DCB7D, 0x09B002DD8BE9E57A},
    {"skin and tethers: leapfrog, a grid", 0x5C59723E70D47424, 0xC98DD9BA87444ABC},
    {"skin and tethers: leapfrog, a list", 0x5C59723E70D47424, 0xC98DD9BA87444ABC},
    {"skin and tethers: fourth order, a grid", 0xF24BFC18BC2FB4E1, 0x665E22EAACF85FBB},
    {"skin and tethers: fourth order, a list", 0xF24BFC18BC2FB4E1, 0x665E22EAACF85FBB},
    {"skin and tethers: generalized alpha, a grid", 0xBF376226ECF7CFF7, 0x77023300283E1635},
    {"skin and tethers: generalized alpha, a list", 0x6BD8A1173AD626FB, 0x7CAF03BAABE29853},
    {"skin and tethers: accumulate, a grid", 0x2945B78A440839BE, 0xE994F686ADFBF6F2},
    {"skin and tethers: accumulate, a list", 0x2945B78A440839BE, 0xE994F686ADFBF6F2},
    {"meet: grains", 0x619F692A4EDA578F, 0x1540D57BF869A157},
    {"meet: a sheet", 0x93BF79ACCDCEAB02, 0x1A86204B4677B65E},
    {"a sheet in contact: leapfrog", 0xD0C5280F76A30312, 0x19F08B308C9D618B},
    {"a sheet in contact: fourth order", 0xBE67D875910697D2, 0xCF9385B8F98627F1},
    {"a sheet in contact: sequential", 0x3DFB32D4F6510FD6, 0xBF6860E5DBAEDE57},
    {"a sheet in contact: sequential, theta 1", 0x2852ACA9C0937715, 0x3AF9ECD365277E0B},
    {"motions: leapfrog", 0x8E89C82E2CC1FA4D, 0xCFC1989C43DE9F89},
    {"motions: fourth order", 0xC5335781BA6B3616, 0x840BC750263FFF2A},
    {"motions: sequential", 0x807697B6424FA297, 0xF7D25C4493FD65B8},
    {"motions: generalized alpha", 0x25B2AF8F04AF8A20, 0xEC5DA7D5B9EB26D9},
    {"motions: particles that nothing joins", 0x23CDAA3392563B98, 0xEFB3BED0ADD81D7E},
    {"constraints: rods", 0x8F46FD0E2D4D1594, 0x021282B1332657FC},
    {"constraints: ropes", 0xA20BAA73353BDE88, 0x3C270258E9B0A615},
    {"constraints: at least", 0x7AF9D5D0AC0B248F, 0x99A75D3DB14C54D6},
    {"constraints: points and lines", 0xE695E5726A8C1D65, 0x3B3ABF382C531B67},
    {"constraints: rods that fall on a plane, in the wind", 0x275E21BC1902ADD2, 0xA4C388BA98441C4A},
    {"constraints: in a sheet, leapfrog", 0x77A0FD1AEBC50A90, 0xC4F31696C1A3034F},
    {"constraints: in a sheet, sequential", 0xE3E0B26EDFDE64A8, 0xA3C16CA630861F36},
    {"generalized alpha: grid, coarse", 0x5A589758933E3E56, 0x2803A25CDC1BD18C},
    {"generalized alpha: list, coarse", 0xBB99F638777F75CF, 0x3C2C51351F56C58E},
    {"generalized alpha: list with a spring across, coarse", 0xCCD77B7347F8AB03, 0xD5EAE4C2C9652E29},
    {"generalized alpha: list with a spring across, coarse, in lines", 0x8924B93EFDF4A8B4, 0x78FC32C0C6EA7491},
    {"generalized alpha: grid, fine", 0xBAAEB431F67EE2C6, 0x612BA24DC88C851C},
    {"generalized alpha: list, fine", 0xB19BE339447F5F14, 0x78352446BEAB8F42},
    {"generalized alpha: list with a spring across, fine", 0x956354DAB692A6B9, 0xAA38CA49B232359C},
    {"generalized alpha: list with a spring across, fine, in lines", 0x6B373B9903440F0B, 0x848F6A7777B15BE9},
    {"generalized alpha: grid, damped", 0x71D6FB22F2C747F6, 0x6A7E20E3FBFFC9FA},
    {"generalized alpha: list, damped", 0x13F81F2C48CD0E18, 0xE3F19BD0133BB2A7},
    {"generalized alpha: list with a spring across, damped", 0x1A9ECEB737C452A0, 0x7262F9B400FF08FF},
    {"generalized alpha: list with a spring across, damped, in lines", 0x489FB31F70329D7C, 0x358B90B6F3C59607},
    {"generalized alpha: grid, in contact", 0x8BAF556F4DC38388, 0x4F4B37B401B2721F},
    {"generalized alpha: list, in contact", 0x8B3094CD0436A2CD, 0x5109F5F677A09F4B},
    {"generalized alpha: list with a spring across, in contact", 0x80608B411BC29A1C, 0x38825693542F2209},
    {"generalized alpha: list with a spring across, in contact, in lines", 0xCED96FF408E552BE, 0xE43DBABC38BEC794},
    {"generalized alpha: grid, constrained", 0x042369664C80A079, 0xFD035DC7BFD5C889},
    {"generalized alpha: list, constrained", 0x28CE015A5143027A, 0x5A9400CF7561BC56},
    {"generalized alpha: list with a spring across, constrained", 0x2B5D4C457DB808BD, 0x453651CBAFE95CB3},
    {"generalized alpha: list with a spring across, constrained, in lines", 0xA6DE8D77AA0CFF66, 0xD832C9A6C9E16012},
    {"compensated: every flow", 0x44ACABB6BF70C235, 0},
    {"compensated: contacts", 0x9A2F9120D055F0DF, 0},
    {"compensated: radial springs", 0xA59F14D1E902697F, 0},
    {"compensated: both", 0xB131056095CC6079, 0},
    {"compensated: 5 x 12", 0x6EB6505CEBC4C268, 0},
    {"compensated: constraints: rods", 0x796B9A477454C26D, 0},
    {"lifecycle: births at a point", 0x96D597FCAC11F5D0, 0},
    {"lifecycle: births on a disc", 0x0BA1315BF9BB0553, 0},
    {"lifecycle: births in a box", 0x759D697ABE4532F6, 0},
    {"lifecycle: births beyond the capacity", 0xC04837DE26F01ECE, 0},
    {"lifecycle: removal", 0xA65EDB66AFFD6310, 0},
    {"lifecycle: births and removal", 0x38FF33A7C27020F4, 0},
    {"lifecycle: births and removal without order", 0x438314195213573C, 0},
};

constexpr std::uint64_t hash_start = 0xCBF29CE484222325U;

// FNV-1a over the little-endian bytes.
template <class T>
std::uint64_t hash(std::uint64_t hash, const std::vector<T>& values) {
  for (const T value : values) {
    std::array<unsigned char, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), &value, sizeof(T));
    for (const unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001B3U;
  }
  return hash;
}

template <class T>
std::vector<T> stepped(const test::NamedScene& scene, Isa isa, Arithmetic arithmetic, std::size_t count) {
  test::Batch<T> batch(test::Layout::soa, count);
  test::place(batch.view());
  const auto plan = compile<T>(scene.scene, {.step = scene.step, .isa = isa, .arithmetic = arithmetic}, batch.view());
  REQUIRE(plan.has_value());
  REQUIRE(plan->step(batch.view(), 40) == StepResult::done);
  return test::values_of(batch.view());
}

std::uint64_t golden(Isa isa, Arithmetic arithmetic) {
  constexpr std::size_t count = 37;
  std::uint64_t sum = hash_start;
  for (const test::NamedScene& scene : test::all_scenes(count)) {
    sum = hash(sum, stepped<float>(scene, isa, arithmetic, count));
    sum = hash(sum, stepped<double>(scene, isa, arithmetic, count));
  }
  return sum;
}

template <class T>
std::vector<T> stepped(const test::Joined& joined, Isa isa, Arithmetic arithmetic = Arithmetic::separate,
                       std::size_t steps = 6) {
  test::Batch<T> batch(test::Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const auto plan = compile<T>(joined.scene, {.step = joined.step, .isa = isa, .arithmetic = arithmetic}, batch.view());
  REQUIRE_MESSAGE(plan.has_value(), joined.name << ": " << plan.error().message());
  REQUIRE(plan->step(batch.view(), steps) == StepResult::done);
  return test::values_of(batch.view());
}

// Sub-steps are given: the chosen number depends on an eigenvalue, which need not be the same to its last bit.
std::uint64_t golden_of_networks(Isa isa) {
  std::uint64_t sum = hash_start;
  for (const Coupling& coupling :
       {Coupling{.scheme = Scheme::sequential, .substeps = 3, .theta = 0.55},
        Coupling{.scheme = Scheme::accumulate, .substeps = 20, .method = Method::average_acceleration},
        Coupling{.scheme = Scheme::accumulate, .substeps = 20, .method = Method::combined}}) {
    test::Joined sheet = test::sheet(9, 20, 50, 0.001);
    sheet.scene.coupling = coupling;
    for (const test::Joined& joined : {sheet, test::as_list(sheet), test::with_spring_across(test::as_list(sheet))}) {
      sum = hash(sum, stepped<float>(joined, isa));
      sum = hash(sum, stepped<double>(joined, isa));
    }
  }
  return sum;
}

// ---- a line a case -----------------------------------------------------------------------------------------------------

constexpr std::size_t count = 53;  // whole registers and a rest, on every instruction set

struct Case {
  std::string name;
  std::function<std::uint64_t(Isa, Arithmetic)> hash;
  bool has_contracted = true;
};
using Cases = std::vector<Case>;

Case case_of(const test::NamedScene& scene) {
  return {scene.name, [scene](Isa isa, Arithmetic arithmetic) {
            return hash(hash(hash_start, stepped<float>(scene, isa, arithmetic, count)),
                        stepped<double>(scene, isa, arithmetic, count));
          }};
}
Case case_of(const test::Joined& joined, std::size_t steps = 6) {
  return {joined.name, [joined, steps](Isa isa, Arithmetic arithmetic) {
            return hash(hash(hash_start, stepped<float>(joined, isa, arithmetic, steps)),
                        stepped<double>(joined, isa, arithmetic, steps));
          }};
}
// Steps of many sub-steps or iterations, each of which does what all do.
constexpr std::size_t few = 2;

const std::array<std::pair<Method, const char*>, 5> methods = {{{Method::combined, "combined"},
                                                                {Method::exact, "exact"},
                                                                {Method::average_acceleration, "average acceleration"},
                                                                {Method::pulse, "pulse"},
                                                                {Method::symplectic_euler, "symplectic Euler"}}};

template <class Shape>
Shape touched(Shape shape, Response response, ContactPath sweep) {
  shape.restitution = 0.6;
  shape.friction = 0.3;
  shape.viscosity = 0.15;
  shape.normal_viscosity = 0.05;
  shape.response = response;
  shape.sweep = sweep;
  return shape;
}

// Every shape, response and sweep by itself; two walls that a particle meets in one step.
Cases contact_cases() {
  Cases cases;
  const std::pair<Contact, const char*> shapes[] = {
      {Plane{.normal = {0.3, 2, -0.1}, .offset = -0.5}, "plane"},
      {Sphere{.center = {0.2, -0.4, 0}, .radius = 0.45}, "sphere"},
      {Sphere{.center = {0, 0.1, 0}, .radius = 1.7, .side = Side::inside}, "inside a sphere"},
      {Capsule{.ends = {{{-0.4, -0.4, 0.1}, {0.5, -0.5, 0}}}, .radius = {0.2, 0.3}}, "capsule"},
      {OrientedBox{.center = {0.1, -0.5, 0}, .half_extents = {0.6, 0.2, 0.5}, .rotation = {0.2, 0.3, -0.1}, .thickness = 0.05},
       "box"},
      {OrientedBox{.half_extents = {1.1, 1.2, 1.3}, .rotation = {0.2, 0.3, -0.1}, .side = Side::inside}, "inside a box"},
      {Convex{.planes = {{{0, 1, 0}, -0.3},
                         {{0, -3, 0}, 0.6},
                         {{1, 0.5, 0}, 0.5},
                         {{-1, 0.5, 0}, 0.4},
                         {{0, 0.5, 1}, 0.4},
                         {{0, 0, -1}, 0.5}}},
       "convex body"},
      {TriangleMesh{
           .vertices = {{0.7, -0.4, 0}, {-0.5, -0.4, 0.1}, {0.1, 0.1, 0}, {0.1, -0.8, 0}, {0.1, -0.4, 0.6}, {0.1, -0.4, -0.5}},
           .triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}},
           .cell = 0.07},
       "mesh"}};
  const std::pair<Response, const char*> responses[] = {{Response::resume, "resume"}, {Response::end_on_surface, "seed"}};
  const std::pair<ContactPath, const char*> sweeps[] = {{ContactPath::curve, "curve"}, {ContactPath::line, "line"}};
  for (const auto& [shape, shape_name] : shapes) {
    for (const auto& [response, response_name] : responses) {
      for (const auto& [sweep, sweep_name] : sweeps) {
        test::NamedScene named{.name = std::string("contact: ") + shape_name + ", " + response_name + ", " + sweep_name,
                               .scene = {}};
        named.scene.add(Constant{.acceleration = {0.5, -9.81, 0}});
        const auto touch = [response = response, sweep = sweep](auto s) { return Contact(touched(s, response, sweep)); };
        named.scene.add(std::visit(touch, shape));
        cases.push_back(case_of(named));
      }
    }
  }
  test::NamedScene corner{.name = "contact: a corner of two planes and a sphere", .scene = {}};
  corner.scene.add(Constant{.acceleration = {4, -9.81, 0}});
  corner.scene.add(Spring{.stiffness = 30.0, .damping = 0.1});
  corner.scene.add(Plane{.normal = {0, 1, 0}, .offset = -0.3, .restitution = 0.9});
  corner.scene.add(Plane{.normal = {-1, 0.2, 0}, .offset = -0.4, .restitution = 0.8, .friction = 0.2});
  corner.scene.add(touched(Sphere{.center = {0, -0.3, 0}, .radius = 0.2}, Response::resume, ContactPath::curve));
  cases.push_back(case_of(corner));
  test::NamedScene pushing{.name = "contact: a ball and a box that push out", .scene = {}};
  pushing.scene.add(Constant{.acceleration = {0.5, -9.81, 0}});
  pushing.scene.add(Sphere{.center = {0.2, -0.4, 0}, .radius = 0.9, .friction = 0.3, .push_out = 0.7});
  pushing.scene.add(
      OrientedBox{.center = {-0.3, 0.3, 0}, .half_extents = {0.5, 0.4, 0.6}, .rotation = {0.2, 0.3, -0.1}, .push_out = 2});
  cases.push_back(case_of(pushing));
  return cases;
}

std::vector<double> numbers(double low, double high, std::uint64_t stream) {
  std::vector<double> list(count);
  for (std::size_t i = 0; i < count; ++i) list[i] = low + (high - low) * test::uniform(stream, i);
  return list;
}

// Every method, with a stiffness, rest length and anchor for all and for each.
Cases radial_cases() {
  Cases cases;
  for (const auto& [method, name] : methods) {
    test::NamedScene named{.name = std::string("radial springs: ") + name, .scene = {}};
    named.scene.method = method;
    named.scene.mass = numbers(0.5, 2, 40);
    named.scene.add(Constant{.acceleration = {0, -9.81, 0}});
    named.scene.add(RadialSpring{.stiffness = 14.0, .damping = 0.2, .anchor = Vec3{0, 0.5, 0}, .rest_length = 0.4});
    named.scene.add(RadialSpring{.stiffness = numbers(4, 40, 41), .anchor = at_start, .rest_length = numbers(0, 0.5, 42)});
    cases.push_back(case_of(named));
  }
  return cases;
}

// A pair's contribution by every method, along both axes, of springs that are damped.
Cases accumulate_cases() {
  Cases cases;
  const std::pair<PairAxis, const char*> axes[] = {{PairAxis::midpoint, "midpoint"}, {PairAxis::start, "start"}};
  for (const auto& [method, name] : methods) {
    for (const auto& [axis, axis_name] : axes) {
      if (method == Method::combined && axis == PairAxis::start) continue;  // its pulse acts at the middle in any case
      test::Joined sheet = test::sheet(7, 18, 50, 0.001);
      sheet.scene.coupling = {.scheme = Scheme::accumulate, .substeps = 20, .method = method, .axis = axis};
      sheet.name = std::string("accumulate: ") + name + ", " + axis_name;
      cases.push_back(case_of(sheet));
    }
  }
  return cases;
}

// Springs that each particle sums, with damping and without: a grid that bends, the list of its springs, and a rope beside it,
// where one of the two networks alone is damped. Sub-steps are given, as above.
Cases pulse_cases() {
  Cases cases;
  for (const auto& [coupling, scheme] : {std::pair{Coupling{.scheme = Scheme::leapfrog, .substeps = 10}, "leapfrog"},
                                         std::pair{Coupling{.scheme = Scheme::fourth_order, .substeps = 6}, "fourth order"}}) {
    const auto add = [&, coupling = coupling, scheme = scheme](test::Joined joined, const std::string& name) {
      joined.scene.coupling = coupling;
      joined.name = std::string("springs: ") + scheme + ", " + name;
      cases.push_back(case_of(joined, few));
    };
    for (const double damping : {0.0, 0.001}) {
      const std::string how = damping == 0 ? "" : ", damped";
      test::Joined sheet = test::sheet(9, 20, 50, damping);
      std::get<Grid>(sheet.scene.networks[0]).bend = 5;
      std::vector<double> masses;
      for (std::size_t i = 0; i < sheet.x.size(); ++i) masses.push_back(0.001 * (1.5 + test::scatter(i, 6)));
      sheet.scene.mass = Scalars(masses);
      add(sheet, "a grid" + how);
      add(test::as_list(sheet), "a list" + how);
      sheet.scene.add(Network(Springs{.pairs = {{0, 45}, {45, 101}, {101, 179}}, .stiffness = 20.0, .damping = 0.001}));
      add(sheet, (damping == 0 ? "a grid, and a rope that is damped" : "a grid and a rope, both damped"));
    }
  }
  return cases;
}

// A grid and a list in a wind that gusts, with a torn side and one particle that is held, by every way in which air acts.
Cases air_cases() {
  Cases cases;
  for (const auto& [coupling, scheme] :
       {std::pair{Coupling{.scheme = Scheme::leapfrog, .substeps = 10}, "leapfrog"},
        std::pair{Coupling{.scheme = Scheme::fourth_order, .substeps = 6}, "fourth order"},
        std::pair{Coupling{.scheme = Scheme::sequential, .substeps = 4, .theta = 0.55}, "sequential"},
        std::pair{Coupling{.scheme = Scheme::sequential, .substeps = 4}, "generalized alpha"},
        std::pair{Coupling{.scheme = Scheme::accumulate, .substeps = 20, .method = Method::exact}, "accumulate"}}) {
    for (const double damping : {0.0, 0.001}) {
      test::Joined sheet = test::sheet(9, 20, 50, damping);
      sheet.scene.coupling = coupling;
      Grid& grid = std::get<Grid>(sheet.scene.networks[0]);
      grid.aerodynamics = Aerodynamics{.density = 1.5, .drag = 0.9, .lift = 0.6};
      grid.broken = {{45, 46}};
      sheet.scene.wind = {.mean = {4, 1, -2}, .gusts = {{{0, 1, 2}, 6, 0.4}}};
      const std::string how = damping == 0 ? "" : ", damped";
      const std::string name = std::string("air: ") + scheme;
      sheet.name = name + ", a grid" + how;
      cases.push_back(case_of(sheet, few));
      test::Joined list = test::as_list(sheet);
      list.name = name + ", a list" + how;
      cases.push_back(case_of(list, few));
    }
  }
  return cases;
}

// A sheet on a skin that is carried and turns, out of the balls behind it, tethered; and a list of its springs.
Cases skin_cases() {
  Cases cases;
  for (const auto& [coupling, scheme] :
       {std::pair{Coupling{.scheme = Scheme::leapfrog, .substeps = 6}, "leapfrog"},
        std::pair{Coupling{.scheme = Scheme::fourth_order, .substeps = 6}, "fourth order"},
        std::pair{Coupling{.scheme = Scheme::sequential, .substeps = 4}, "generalized alpha"},
        std::pair{Coupling{.scheme = Scheme::accumulate, .substeps = 20, .method = Method::exact}, "accumulate"}}) {
    test::Joined sheet = test::sheet(9, 20, 50, 0.001);
    sheet.scene.coupling = coupling;
    Skin skin{.particles = {}, .at_most = 0.0, .motion = 0};
    std::vector<double> at_most, offset;
    for (std::size_t i = 0; i < sheet.x.size(); i += 1 + i % 3) {
      skin.particles.push_back(i);
      at_most.push_back(0.02 * (1 + test::scatter(i, 7)));
      offset.push_back(0.01 * (1 + test::scatter(i, 8)));
    }
    skin.at_most = at_most;
    skin.backstop = Backstop{.normals = {{0.2, 2, 0.4}}, .offset = offset, .radius = 0.1};
    sheet.scene.add(std::move(skin));
    sheet.scene.add(Tethers{.network = 0, .stretch = 1.0});
    sheet.scene.add(Motion{.center = {0.5, 0, 0.5},
                           .keys = {{.time = 0}, {.time = 0.1, .translation = {0.1, 0.05, 0}, .rotation = {0, 0.3, 0.2}}}});
    sheet.name = std::string("skin and tethers: ") + scheme + ", a grid";
    cases.push_back(case_of(sheet));
    test::Joined list = test::as_list(sheet);
    list.name = std::string("skin and tethers: ") + scheme + ", a list";
    cases.push_back(case_of(list));
  }
  return cases;
}

// Grains of two sizes that fall into a corner, and a sheet that folds.
Cases meet_cases() {
  test::Joined grains;
  grains.name = "meet: grains";
  std::vector<double> radius;
  for (std::size_t i = 0; i < 40; ++i) {
    const auto place = [&](std::size_t k, std::size_t axis) {
      return 0.02 * (static_cast<double>(k) + 1 + 0.1 * test::scatter(i, axis));
    };
    grains.x.push_back({place(i % 4, 0), place(i / 16, 1), place(i / 4 % 4, 2)});
    grains.v.push_back({0.5 * test::scatter(i, 3), -1, 0.5 * test::scatter(i, 4)});
    radius.push_back(i % 3 == 0 ? 0.012 : 0.009);
  }
  grains.scene.add(Constant{.acceleration = {-2, -9.75, 0}});
  grains.scene.add(Plane{.normal = {0, 1, 0}, .friction = 0.5});
  grains.scene.add(Plane{.normal = {1, 0, 0}, .restitution = 0.5});
  grains.scene.fixed = {7};
  grains.scene.add(Meet{.radius = radius, .restitution = 0.5, .friction = 0.25, .rounds = 4});
  test::Joined sheet = test::sheet(9, 12, 50, 0.001);
  sheet.name = "meet: a sheet";
  sheet.scene.coupling.scheme = Scheme::sequential;
  sheet.scene.add(Meet{.thickness = 0.02, .friction = 0.5, .rounds = 4, .most_neighbours = 64});
  for (std::size_t i = 0; i < sheet.v.size(); ++i) sheet.v[i][0] = sheet.x[i][0] > 0.25 ? -4 : 4;
  return {case_of(grains), case_of(sheet)};
}

// A sheet that falls on a sphere and is kept from sinking into a plane.
Cases sheet_contact_cases() {
  Cases cases;
  const auto add = [&](Scheme scheme, double theta, const char* name) {
    test::Joined sheet = test::sheet(7, 18, 50, 0.001);
    sheet.scene.coupling = {.scheme = scheme, .substeps = 8, .theta = theta};
    sheet.scene.add(touched(Sphere{.center = {0.5, -0.15, 0.5}, .radius = 0.14}, Response::resume, ContactPath::curve));
    sheet.scene.add(touched(Plane{.normal = {0, 1, 0}, .offset = -0.02}, Response::end_on_surface, ContactPath::line));
    sheet.name = std::string("a sheet in contact: ") + name;
    cases.push_back(case_of(sheet));
  };
  add(Scheme::leapfrog, 0.55, "leapfrog");
  add(Scheme::fourth_order, 0.55, "fourth order");
  add(Scheme::sequential, 0.55, "sequential");
  add(Scheme::sequential, 1, "sequential, theta 1");
  return cases;
}

// A chain of particles two centimetres apart, moving, its first particle fixed.
test::Joined chain(std::string name) {
  test::Joined joined;
  joined.name = "constraints: " + std::move(name);
  for (std::size_t i = 0; i < count; ++i) {
    joined.x.push_back({0.02 * static_cast<double>(i), 0.004 * test::scatter(i, 1), 0.004 * test::scatter(i, 2)});
    joined.v.push_back({0.3 * test::scatter(i, 3), 0.3 * test::scatter(i, 4), 0.3 * test::scatter(i, 5)});
  }
  joined.scene.mass = numbers(0.5, 2, 50);
  joined.scene.fixed = {0};
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  return joined;
}

// A row of a sheet that is swung, above a sphere that passes and a plane that tilts; and particles with no sheet among them.
Cases motion_cases() {
  const auto add_world = [](Scene& scene) {
    scene.add(
        Motion{.center = {0.5, 0, 0}, .keys = {{}, {.time = 0.3, .translation = {0.1, 0, 0.2}, .rotation = {0, 0.5, 0.2}}}});
    scene.add(Motion{.keys = {{.time = 0.05}, {.time = 0.35, .translation = {0.5, 0.1, 0}}}});
    Sphere sphere = touched(Sphere{.center = {0.2, -0.15, 0.5}, .radius = 0.14}, Response::resume, ContactPath::curve);
    sphere.motion = 1;
    scene.add(sphere);
    Plane plane = touched(Plane{.normal = {0, 1, 0}, .offset = -0.05}, Response::resume, ContactPath::curve);
    plane.motion = 0;
    scene.add(plane);
  };
  Cases cases;
  const Coupling couplings[] = {{.scheme = Scheme::leapfrog, .substeps = 6},
                                {.scheme = Scheme::fourth_order, .substeps = 6},
                                {.scheme = Scheme::sequential, .substeps = 3, .theta = 0.55},
                                {.scheme = Scheme::sequential, .substeps = 3}};
  const char* names[] = {"leapfrog", "fourth order", "sequential", "generalized alpha"};
  for (std::size_t k = 0; k < std::size(couplings); ++k) {
    test::Joined sheet = test::sheet(7, 18, 50, 0.001);
    sheet.scene.coupling = couplings[k];
    sheet.scene.fixed.clear();
    add_world(sheet.scene);
    sheet.scene.add(Kinematic{.particles = {0, 1, 2, 3, 16, 17}, .motion = 0});
    sheet.name = std::string("motions: ") + names[k];
    cases.push_back(case_of(sheet));
  }
  test::Joined loose = chain("rods");
  loose.scene.fixed.clear();
  loose.scene.add(Drag{.coefficient = 0.2});
  add_world(loose.scene);
  loose.name = "motions: particles that nothing joins";
  cases.push_back(case_of(loose));
  return cases;
}

std::vector<Pair> neighbours() {
  std::vector<Pair> pairs;
  for (std::uint32_t i = 0; i + 1 < count; ++i) pairs.push_back({i, i + 1});
  return pairs;
}

Cases constraint_cases() {
  Cases cases;
  const std::pair<Bound, const char*> bounds[] = {
      {Bound::equal, "rods"}, {Bound::at_most, "ropes"}, {Bound::at_least, "at least"}};
  for (const auto& [bound, name] : bounds) {
    test::Joined joined = chain(name);
    joined.scene.add(Distance{.pairs = neighbours(), .length = 0.02, .bound = bound});
    cases.push_back(case_of(joined));
  }
  test::Joined held = chain("points and lines");
  held.scene.add(OnPoint{.particle = 9, .at = {0.2, 0.05, 0}});
  held.scene.add(OnLine{.particle = 30, .through = {0.6, 0, 0.01}, .direction = {1, 2, -0.5}});
  held.scene.add(Distance{.pairs = neighbours()});
  cases.push_back(case_of(held, few));

  test::Joined wall = chain("rods that fall on a plane, in the wind");
  wall.scene.add(Drag{.coefficient = 0.3, .wind = {3, 0, 1}});
  wall.scene.add(Plane{.normal = {0, 1, 0}, .offset = -0.05, .restitution = 0.3, .friction = 0.4});
  wall.scene.add(Distance{.pairs = neighbours(), .length = 0.02});
  cases.push_back(case_of(wall));

  for (const auto& [scheme, name] : {std::pair{Scheme::leapfrog, "leapfrog"}, std::pair{Scheme::sequential, "sequential"}}) {
    test::Joined sheet = test::sheet(6, 11, 50, 0.001);
    sheet.scene.coupling = {.scheme = scheme, .substeps = 8, .theta = 0.55};
    sheet.scene.add(Distance{.pairs = {{1, 2}, {2, 3}, {12, 23}, {40, 41}}, .bound = Bound::at_most});
    sheet.name = std::string("constraints: in a sheet, ") + name;
    cases.push_back(case_of(sheet));
  }
  return cases;
}

// Sequential without theta, in all forms of its sweeps: damped and not, coarse and fine sub-steps, in contact and constrained.
Cases generalized_alpha_cases() {
  Cases cases;
  const auto add = [&](test::Joined sheet, int substeps, const std::string& what) {
    sheet.scene.coupling = {.scheme = Scheme::sequential, .substeps = substeps};
    test::Joined list = test::as_list(sheet);
    test::Joined across = test::with_spring_across(list);
    sheet.name = "generalized alpha: grid, " + what;
    list.name = "generalized alpha: list, " + what;
    across.name = "generalized alpha: list with a spring across, " + what;
    test::Joined in_lines = across;
    in_lines.scene.coupling.lines = Lines::whole;
    in_lines.name = across.name + ", in lines";
    for (const test::Joined& joined : {sheet, list, across, in_lines}) {
      cases.push_back(substeps == 12 ? case_of(joined, few) : case_of(joined));
    }
  };
  add(test::sheet(9, 20, 50), 1, "coarse");
  add(test::sheet(9, 20, 50), 12, "fine");
  add(test::sheet(9, 20, 50, 0.001), 3, "damped");
  test::Joined touching = test::sheet(7, 18, 50, 0.001);
  touching.scene.add(touched(Sphere{.center = {0.5, -0.15, 0.5}, .radius = 0.14}, Response::resume, ContactPath::curve));
  add(touching, 3, "in contact");
  test::Joined held = test::sheet(6, 11, 50);
  held.scene.add(Distance{.pairs = {{1, 2}, {2, 3}, {12, 23}, {40, 41}}, .bound = Bound::at_most});
  add(held, 2, "constrained");
  return cases;
}

// ---- compensated states ------------------------------------------------------------------------------------------------

template <class Place>
std::uint64_t compensated_hash(const Scene& scene, double step, std::size_t particles, std::size_t steps, Isa isa,
                               const Place& place) {
  test::Batch<float> values(test::Layout::soa, particles);
  test::Batch<float> rests(test::Layout::soa, particles);
  for (const auto* columns : {&rests.view().x, &rests.view().v}) {
    for (const Column<float>& column : *columns) {
      for (std::size_t i = 0; i < particles; ++i) column[i] = 0;
    }
  }
  place(values.view());
  State<float> state = compensated(values.view(), rests.view());
  const auto plan = compile<float>(scene, {.step = step, .isa = isa, .rounding = Rounding::compensated}, state);
  REQUIRE(plan.has_value());
  for (std::size_t n = 0; n < steps; ++n) REQUIRE(plan->step(state) == StepResult::done);  // each call splits and joins
  return hash(hash(hash_start, test::values_of(values.view())), test::values_of(rests.view()));
}

// Every flow as it is, with contacts, with radial springs and with both.
Cases compensated_cases() {
  Cases cases;
  for (const auto& [features, name] :
       {std::pair{StepFeatures::none, "every flow"}, std::pair{StepFeatures::contact, "contacts"},
        std::pair{StepFeatures::radial, "radial springs"}, std::pair{StepFeatures::radial_contact, "both"}}) {
    const auto run = [features = features](Isa isa, Arithmetic) {
      const auto place = [](State<float>& state) { test::place(state); };
      std::uint64_t sum = hash_start;
      for (const test::NamedScene& scene : test::affine_scenes(count)) {
        sum = hash(sum, std::vector{compensated_hash(test::with(scene, features).scene, scene.step, count, 10, isa, place)});
      }
      return sum;
    };
    cases.push_back({std::string("compensated: ") + name, run, false});
  }
  for (test::Joined joined : {test::sheet(5, 12, 50, 0.001), chain("rods")}) {
    if (joined.scene.networks.empty()) joined.scene.add(Distance{.pairs = neighbours(), .length = 0.02});
    joined.scene.coupling.substeps = 8;
    const auto run = [joined](Isa isa, Arithmetic) {
      const auto place = [&joined](State<float>& state) { test::place(joined, state); };
      return compensated_hash(joined.scene, joined.step, joined.x.size(), 5, isa, place);
    };
    cases.push_back({"compensated: " + joined.name, run, false});
  }
  return cases;
}

// ---- particles that come and go ----------------------------------------------------------------------------------------

template <class T>
Column<T> column_of(std::vector<T>& values) {
  return {.base = values.data(), .stride = sizeof(T), .capacity = values.size()};
}

// The hash of the particles alive at the end, with ages, lifetimes and a column that is carried, and of how many were born,
// removed and dropped.
template <class T>
std::uint64_t live_hash(std::uint64_t sum, const Lifecycle& turnover, Isa isa) {
  constexpr double step = 1.0 / 64;
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Drag{.coefficient = 0.002, .wind = {1, 0, 0}});
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.4, .friction = 0.1});
  const auto plan = compile<T>(scene, turnover, {.step = step, .isa = isa});
  REQUIRE(plan.has_value());

  test::Batch<T> batch(test::Layout::soa, turnover.capacity);
  std::vector<T> age(turnover.capacity), lifetime(turnover.capacity);
  std::vector<std::uint32_t> ids(turnover.capacity);
  const Carried carried{ids.data(), sizeof(std::uint32_t), sizeof(std::uint32_t)};
  LiveState<T> live{.state = batch.view(), .age = column_of(age), .lifetime = column_of(lifetime), .carried = {&carried, 1}};
  live.state.count = 40;
  test::place(live.state);
  for (std::size_t i = 0; i < live.state.count; ++i) {
    lifetime[i] = i % 3 == 0 ? std::numeric_limits<T>::infinity() : static_cast<T>(0.05 + test::uniform(9, i));
    ids[i] = static_cast<std::uint32_t>(i + 1);
  }
  const bool goes = turnover.removal.not_finite == NotFinite::removed;  // else it becomes a NaN, whose sign is the machine's
  if (goes) live.state.x[1][7] = std::numeric_limits<T>::infinity();
  REQUIRE(plan->step(live, 60) == StepResult::done);

  const std::size_t alive = live.state.count;
  REQUIRE(alive > 0);
  age.resize(alive);
  lifetime.resize(alive);
  ids.resize(alive);
  sum = hash(hash(hash(sum, test::values_of(live.state)), age), lifetime);
  return hash(hash(sum, ids), std::vector<std::uint64_t>{alive, live.born, live.removed, live.dropped});
}

Cases live_cases() {
  const Emitter jet{.rate = 400, .velocity = {0, 3, 0}, .spread = 0.5, .least_lifetime = 0.1, .most_lifetime = 0.4, .seed = 1};
  Emitter disc = jet;
  disc.shape = Disc{.center = {0, 0.1, 0}, .normal = {0.2, 1, 0.4}, .radius = 0.05};
  Emitter box = jet;
  box.shape = Box{.min = {-1, 0, -1}, .max = {-0.5, 1, -1}};
  box.spread = Vec3{0.1, 0.5, 0};
  box.start = 0.08;
  box.end = 0.6;
  box.seed = 0x1234567890;
  Emitter mortal = jet;
  mortal.rate = 3000;
  const Removal all{.boundaries = {{.normal = {1, 0, 0}, .offset = -0.7}, {.normal = {-2, 1, 0}, .offset = -2}},
                    .outside = Box{.min = {-9, -9, -9}, .max = {9, 1.2, 9}},
                    .not_finite = NotFinite::removed};
  Removal without_order = all;
  without_order.order = SurvivorOrder::any;
  const std::pair<const char*, Lifecycle> turnovers[] = {
      {"births at a point", {.emitters = {jet}, .capacity = 900}},
      {"births on a disc", {.emitters = {disc}, .capacity = 900}},
      {"births in a box", {.emitters = {box}, .capacity = 900}},
      {"births beyond the capacity", {.emitters = {mortal, disc}, .capacity = 200}},
      {"removal", {.emitters = {}, .removal = all, .capacity = 40}},
      {"births and removal", {.emitters = {disc, box}, .removal = all, .capacity = 900}},
      {"births and removal without order", {.emitters = {disc, box}, .removal = without_order, .capacity = 900}}};
  Cases cases;
  for (const auto& [name, turnover] : turnovers) {
    const auto run = [turnover = turnover](Isa isa, Arithmetic) {
      return live_hash<double>(live_hash<float>(hash_start, turnover, isa), turnover, isa);
    };
    cases.push_back({std::string("lifecycle: ") + name, run, false});
  }
  return cases;
}

Cases all_cases() {
  Cases all;
  for (const Cases& cases : {contact_cases(), radial_cases(), accumulate_cases(), pulse_cases(), air_cases(), skin_cases(),
                             meet_cases(), sheet_contact_cases(), motion_cases(), constraint_cases(), generalized_alpha_cases(),
                             compensated_cases(), live_cases()}) {
    all.insert(all.end(), cases.begin(), cases.end());
  }
  return all;
}

// A line of the table above, of what the scalar reference gives now.
std::string line_of(const Case& tried) {
  std::array<char, 40> numbers{};
  std::snprintf(numbers.data(), numbers.size(), "0x%016llX, ",
                static_cast<unsigned long long>(tried.hash(Isa::reference, Arithmetic::separate)));
  std::string line = "    {\"" + tried.name + "\", " + numbers.data();
  if (!tried.has_contracted) return line + "0},";
  std::snprintf(numbers.data(), numbers.size(), "0x%016llX},",
                static_cast<unsigned long long>(tried.hash(Isa::reference, Arithmetic::contracted)));
  return line + numbers.data();
}

TEST_CASE("golden: the hash of all networks is the committed one on every ISA") {
  for (const Isa isa : available_isas()) {
    CAPTURE(name(isa));
    CHECK(golden_of_networks(isa) == golden_networks);
  }
}

TEST_CASE("golden: the hash of all scenes is the committed one on every ISA") {
  for (const Isa isa : available_isas()) {
    CAPTURE(name(isa));
    CHECK(golden(isa, Arithmetic::separate) == golden_separate);
  }
  for (const Isa isa : available_isas(Arithmetic::contracted)) {
    CAPTURE(name(isa));
    CHECK(golden(isa, Arithmetic::contracted) == golden_contracted);
  }
}

TEST_CASE(
    "golden: the hash of each contact, motion, radial spring, pair, constraint, rest and life is the committed one on every "
    "ISA") {
  std::map<std::string_view, Golden> left;
  for (const Golden& line : golden_cases) left[line.name] = line;
  std::size_t tried = 0;
  for (const Case& one : all_cases()) {
    const auto found = left.find(one.name);
    ++tried;
    if (found == left.end()) {
      FAIL_CHECK("a case without a hash, or its name is there twice:\n" << line_of(one));
      continue;
    }
    bool is_same = true;
    for (const Isa isa : available_isas()) is_same = is_same && one.hash(isa, Arithmetic::separate) == found->second.separate;
    if (one.has_contracted) {
      for (const Isa isa : available_isas(Arithmetic::contracted)) {
        is_same = is_same && one.hash(isa, Arithmetic::contracted) == found->second.contracted;
      }
    }
    CHECK_MESSAGE(is_same, "the scalar reference gives\n" << line_of(one));
    left.erase(found);
  }
  CHECK_MESSAGE(left.empty(), left.size() << " hashes belong to no case");
  MESSAGE(tried << " cases");
}

}  // namespace golden_test
