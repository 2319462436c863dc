#include "core/image/tiny_font.h"

#include <array>
#include <cstdint>

namespace relume {
namespace {

constexpr int glyph_width = 5;
constexpr int advance = glyph_width + 1;

/// Rows top to bottom; bit 4 is the leftmost dot.
using Glyph = std::array<uint8_t, tiny_font_height>;

struct FontEntry {
  char character;
  Glyph rows;
};

constexpr std::array<FontEntry, 14> font{{
    {'0', {0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110}},
    {'1', {0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'2', {0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111}},
    {'3', {0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110}},
    {'4', {0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010}},
    {'5', {0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110}},
    {'6', {0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110}},
    {'7', {0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000}},
    {'8', {0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110}},
    {'9', {0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100}},
    {'.', {0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b01100}},
    {'-', {0b00000, 0b00000, 0b00000, 0b11111, 0b00000, 0b00000, 0b00000}},
    {'+', {0b00000, 0b00100, 0b00100, 0b11111, 0b00100, 0b00100, 0b00000}},
    {'e', {0b00000, 0b00000, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110}},
}};

}  // namespace

int tiny_text_width(std::string_view text) {
  return text.empty() ? 0 : static_cast<int>(text.size()) * advance - 1;
}

void draw_tiny_text(std::string_view text, const std::function<void(int x, int y)>& plot) {
  int left = 0;
  for (const char character : text) {
    for (const FontEntry& entry : font) {
      if (entry.character != character) continue;
      for (int y = 0; y < tiny_font_height; ++y) {
        for (int x = 0; x < glyph_width; ++x) {
          if ((entry.rows[static_cast<size_t>(y)] >> (glyph_width - 1 - x)) & 1) plot(left + x, y);
        }
      }
    }
    left += advance;
  }
}

}  // namespace relume
