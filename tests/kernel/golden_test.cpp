// Hashes of the states of every kind of scene after some steps. They must be the same on every machine, with every compiler and
// at every level of optimisation. Otherwise coefficients depend on the build.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <string_view>

#include "dvdx/plan.hpp"
#include "kernel/golden_cases.hpp"
#include "kernel/golden_hash.hpp"

namespace golden_test {

using namespace dvdx;

// After an intended change of arithmetic, the test's message gives the new numbers.
constexpr std::uint64_t golden_separate = 15184788198911441522U;
constexpr std::uint64_t golden_contracted = 14901867960843675406U;
constexpr std::uint64_t golden_networks = 2030490220018824651U;

// The cases not covered by the three hashes above, one a line, so that a change shows which cases it affects. Compensated
// states and particles that come and go have no contracted form: 0.
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

// The line of the table above with the scalar reference's present hashes.
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
