#pragma once

namespace relume {

extern const char* const relume_version;  ///< for instance "0.1.0"
extern const char* const
    relume_commit;  ///< short hash of the sources, "-dirty" appended, or "unknown"

}  // namespace relume
