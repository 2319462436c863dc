#pragma once

#include <cstdint>
#include <string>

#include "viewer/session/prepare_options.h"
#include "viewer/session/view_state.h"

namespace relume {

inline constexpr const char* session_schema = "relume-session-1";
inline constexpr uint64_t max_session_bytes = uint64_t{16} << 20;

/// What a viewer was opened on and everything set in it: enough to show the same picture again.
struct SessionFile {
  std::string input;       ///< label of a built-in scene, or path of a scene or cache
  PrepareOptions prepare;  ///< how a scene becomes records
  uint64_t seed = 0;
  ViewState view;
};

/// As JSON (docs/viewer.md). Numbers read back as the same floats.
std::string format_session(const SessionFile& session);

/// The reverse. `place` is named in messages. What is left out keeps its default; "schema", "input"
/// and "lights" must be there. Throws Error(input) or Error(limit) naming the field, see
/// JsonNode.
SessionFile parse_session(const std::string& text, const std::string& place);

/// True when `text` says that it is a session, of whatever version.
bool is_session(const std::string& text);

}  // namespace relume
