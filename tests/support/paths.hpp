// Where the tests find what is not code. Defined in one file, so that a clone in another place compiles the others alike.
#pragma once

#include <string>

namespace dvdx::test {

[[nodiscard]] std::string oracles();  // the folder of the closed-form answers
[[nodiscard]] std::string scenes();   // the folder of the shipped scenes
[[nodiscard]] std::string schema();   // the JSON Schema of scenes
[[nodiscard]] std::string command();  // the program dvdx
[[nodiscard]] std::string mpirun();   // that starts it on many ranks; empty where it was built without MPI

}  // namespace dvdx::test
