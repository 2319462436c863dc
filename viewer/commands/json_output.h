#pragma once

#include <span>
#include <string>
#include <vector>

#include "viewer/commands/options.h"
#include "viewer/study/figure_row.h"

namespace relume {

/// The program's one shape for figures: {schema, version, commit, cpu, threads, seed, rows: [...]},
/// indented, with a final newline. `schema` names the kind of rows, for instance "relume-render-1".
/// Non-finite numbers become null.
std::string format_figures(const std::string& schema, const CommonOptions& common,
                           const std::vector<FigureRow>& rows);

/// The same with several tables, each under its name.
std::string format_tables(const std::string& schema, const CommonOptions& common,
                          std::span<const FigureTable> tables);

/// Rows as comma-separated values under a line of names, which are the first row's. Text with a
/// comma, quote or line end is quoted.
std::string format_csv(const std::vector<FigureRow>& rows);

/// The same to read: neighbouring rows of the same names as a table, a row by itself as lines
/// "name value".
std::string format_table(std::span<const FigureRow> rows);

/// Prints rows on stdout: as JSON when asked for, else as a table.
void print_figures(const std::string& schema, const CommonOptions& common,
                   const std::vector<FigureRow>& rows);

}  // namespace relume
