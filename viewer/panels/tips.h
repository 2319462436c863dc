#pragma once

#include <string_view>

namespace relume {

/// What the pointer shows of an item (see note_item()) when it stays there; empty where the item
/// says all by itself. Numbers in the name do not matter.
std::string_view tip_of(std::string_view item);

}  // namespace relume
