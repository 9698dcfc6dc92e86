// A picture, and its bytes as a PNG.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace dvdx::tool {

struct Picture {
  std::size_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb{};  // row by row from the top, three bytes a pixel
};

[[nodiscard]] std::string png(const Picture& picture);

// 33 levels of red, green and blue: a third of the bytes.
[[nodiscard]] Picture with_fewer_colours(Picture picture);

// An animated PNG: pictures of one size that follow one another for ever. Programs without animation show the first.
class AnimatedPng {
 public:
  explicit AnimatedPng(std::size_t pictures) : pictures_(pictures) {}

  // The bytes that the next picture adds. seconds: how long it is shown.
  [[nodiscard]] std::string add(const Picture& picture, double seconds);
  [[nodiscard]] static std::string end();

 private:
  std::size_t pictures_;
  std::uint32_t chunks_ = 0;  // of the animation, so far
};

}  // namespace dvdx::tool
