// A file that gathers the bytes it is given and writes them in large pieces: a system call costs as much as copying some
// kilobytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace dvdx::tool {

// Every member that writes throws Fault (input_output), whose message calls the file `named`.
class OutFile {
 public:
  enum class Open { anew, as_it_is };  // anew: creates or empties the file; as_it_is: opens an existing one
  OutFile(const std::filesystem::path& path, Open open, std::filesystem::path named);
  OutFile(const OutFile&) = delete;
  OutFile& operator=(const OutFile&) = delete;
  ~OutFile();  // bytes that are not yet in the file are lost

  void put_at(std::uint64_t place, std::string_view bytes);
  void close();  // writes all bytes; nothing may follow

 private:
  static constexpr std::size_t most = std::size_t{1} << 20U;

  void flush();
  void write_now(std::string_view bytes);

  std::filesystem::path named_;
  int number_;
  std::uint64_t place_ = 0;  // where the gathered bytes go
  std::string gathered_;
};

}  // namespace dvdx::tool
