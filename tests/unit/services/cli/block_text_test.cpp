#include "cli/block_text.hpp"

#include <catch2/catch.hpp>

namespace voxatlas {
namespace {

TEST_CASE("a picture as wide as the terminal is a character for two pixels", "[cli]") {
  Image image(2, 2);
  image.at(0, 0) = {1, 2, 3};
  image.at(1, 0) = {4, 5, 6};
  image.at(0, 1) = {7, 8, 9};
  image.at(1, 1) = {255, 0, 128};
  REQUIRE(block_text(image, 2) ==
          "\033[38;2;1;2;3m\033[48;2;7;8;9m\u2580"
          "\033[38;2;4;5;6m\033[48;2;255;0;128m\u2580\033[0m\n");
}

TEST_CASE("a larger picture is shown in means", "[cli]") {
  Image image(4, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) image.at(x, y).r = static_cast<std::uint8_t>(10 * (4 * y + x));
  }
  REQUIRE(block_text(image, 1) ==
          "\033[38;2;35;0;0m\033[48;2;115;0;0m\u2580\033[0m\n");  // Rows 0, 1 and rows 2, 3.
}

TEST_CASE("any size of picture and terminal gives whole lines", "[cli]") {
  for (const int width : {1, 3, 100}) {
    for (const int height : {1, 2, 7, 300}) {
      for (const int columns : {1, 2, 80}) {
        const std::string text = block_text(Image(width, height), columns);
        CAPTURE(width, height, columns);
        REQUIRE(text.ends_with("\033[0m\n"));
      }
    }
  }
  REQUIRE(block_text(Image(), 80).empty());
  REQUIRE(block_text(Image(1, 1), 0).empty());
}

}  // namespace
}  // namespace voxatlas
