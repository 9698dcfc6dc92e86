// A file that is written in large pieces, whatever the size of those it is given: each call of the system costs what copying
// some kilobytes does.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace dvdx::tool {

// Throws Fault (input_output) from every member that writes, which calls the file `named`.
class OutFile {
 public:
  enum class Open { anew, as_it_is };  // made, and emptied where it is there already; or there already
  OutFile(const std::filesystem::path& path, Open open, std::filesystem::path named);
  OutFile(const OutFile&) = delete;
  OutFile& operator=(const OutFile&) = delete;
  ~OutFile();  // what is not yet in the file is lost

  void put_at(std::uint64_t place, std::string_view bytes);
  void close();  // all bytes are in the file; nothing may follow

 private:
  static constexpr std::size_t most = std::size_t{1} << 20U;

  void flush();
  void write_now(std::string_view bytes);

  std::filesystem::path named_;
  int number_;
  std::uint64_t place_ = 0;  // of what is gathered
  std::string gathered_;
};

}  // namespace dvdx::tool
