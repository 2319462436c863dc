#pragma once

#include <string>

#include "core/math/vec.h"
#include "core/scene/camera.h"
#include "viewer/session/view_state.h"

namespace relume {

/// A point light before the scene, above the camera's left, as bright in the scene's middle as a
/// directional light of gain 1; added at the end and selected. Nothing beyond max_lights.
void add_light(ViewState& view, const Bounds& bounds, const Camera& camera);

/// A copy of the selected light behind it, selected; soloed when the original is.
void duplicate_light(ViewState& view);

/// Removes the selected light; its successor is selected.
void delete_light(ViewState& view);

/// Moves the selected light in the list by `steps`, as far as there is room.
void reorder_light(ViewState& view, int steps);

/// The next light down (steps > 0) or up the list is selected, around its ends.
void select_next_light(ViewState& view, int steps);

/// Soloes a light beside those that are, or takes it out.
void toggle_solo(ViewState& view, int light);
bool is_solo(const ViewState& view, int light);

/// Renames a light as far as a name may go: printable, without dots, not empty, no other light's.
void rename_light(ViewState& view, int light, const std::string& name);

/// Brings every value into the range that files may hold (docs/scene-format.md); one that is not
/// finite becomes that of `before`.
void limit_light(Light& light, const Light& before);

/// Changes the type; a light that had no direction yet is aimed at the middle of `bounds`.
void set_light_type(Light& light, LightType type, const Bounds& bounds);

}  // namespace relume
