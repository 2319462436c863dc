#include "viewer/commands/work_settings.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/mapped_file.h"
#include "core/samples/geometry_hash.h"
#include "viewer/study/trial_log.h"

namespace relume {

std::string hash_program() {
  try {
    const MappedFile file("/proc/self/exe");
    const auto bytes = file.bytes();
    return hash_text({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  } catch (const Error&) {
    return "unknown";
  }
}

std::string describe_work(const CommonOptions& common, const Scene& scene) {
  return fmt::format("program {}\ncommand {}\nscene {}\ngeometry {:016x}\n", hash_program(),
                     common.command_line, scene.text, geometry_hash(scene));
}

}  // namespace relume
