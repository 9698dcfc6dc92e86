// The places of the tests' data files. Defined in one source file, so that a clone in another folder compiles all others alike.
#pragma once

#include <string>

namespace dvdx::test {

[[nodiscard]] std::string oracles();  // the folder of the closed-form answers
[[nodiscard]] std::string scenes();   // the folder of the shipped scenes
[[nodiscard]] std::string schema();   // the JSON Schema of scenes
[[nodiscard]] std::string command();  // the program dvdx
[[nodiscard]] std::string mpirun();   // starts dvdx on many ranks; empty if built without MPI

}  // namespace dvdx::test
