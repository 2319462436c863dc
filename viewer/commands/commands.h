#pragma once

#include <string>

#include "viewer/commands/options.h"

namespace relume {

// One function per subcommand; each returns the exit code and throws Error.

int run_demo(const DemoOptions& options, const CommonOptions& common);
int run_view(const ViewOptions& options, const CommonOptions& common);
int run_prepare(const PrepareCommandOptions& options, const CommonOptions& common);
int run_render(const RenderOptions& options, const CommonOptions& common);
int run_sample(const SampleOptions& options, const CommonOptions& common);
int run_convert(const ConvertOptions& options, const CommonOptions& common);
int run_verify(const VerifyOptions& options, const CommonOptions& common);
int run_compare(const CompareOptions& options, const CommonOptions& common);
int run_bench(const BenchOptions& options, const CommonOptions& common);
int run_info(const InfoOptions& options, const CommonOptions& common);
int run_study(const StudyOptions& options, const CommonOptions& common);

// What processes of one launcher share; all other commands are run by one of them.

/// Tiles: of a scene, with records that are not chosen by measured times.
bool shares_prepare(const PrepareCommandOptions& options);
/// Frames of a range.
bool shares_render(const RenderOptions& options);
/// Trials: of studies that are about errors alone.
bool shares_study(const StudyOptions& options);

/// True when this build has a window and a display is there.
bool can_open_window();

/// Parses the command line and runs the command it names. Prints one line on stderr for an Error
/// and returns its exit code: 0 ok, 1 compared images differ, 2 usage, 3 input, 4 limit, 5 output,
/// 130 interrupted.
int run_command_line(int argc, const char* const* argv);

/// The same without running or printing: empty, or the error's first line. By one thread at a time.
std::string check_command_line(int argc, const char* const* argv);

}  // namespace relume
