#pragma once

#include <functional>
#include <string_view>

namespace relume {

/// Height of a glyph of the built-in font, in dots. A glyph is 5 wide and the advance is 6.
inline constexpr int tiny_font_height = 7;

/// Width of `text` in dots, 0 when empty.
int tiny_text_width(std::string_view text);

/// Calls plot(x, y) for every dot of `text`, from its top left corner. The font holds what numbers
/// need: digits, '.', '-', '+', 'e'; any other character is a gap.
void draw_tiny_text(std::string_view text, const std::function<void(int x, int y)>& plot);

}  // namespace relume
