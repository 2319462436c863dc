#pragma once

#include <filesystem>

#include "viewer/commands/json_output.h"

namespace relume {

/// A picture of a study, which stands in the study's folder. Those of one set show the same part of
/// a scene and can be wiped against each other.
struct StudyPicture {
  std::string set;
  std::string name;
  std::string about;  ///< figures to show beside it; may be empty
  std::string file;   ///< PNG within the folder
  int width = 0;      ///< pixels
  int height = 0;
};

/// What a study found. The first table is called "rows".
struct StudyResult {
  std::string name;
  std::vector<FigureTable> tables;
  std::vector<StudyPicture> pictures;
  std::vector<FigureTable> raw;  ///< written as CSV alone
};

/// A scene's name as part of a file's: other characters than letters, digits, "-", "_" and "."
/// become "-".
std::string file_part(const std::string& name);

/// The study's document, see docs/study.schema.json.
std::string format_study(const StudyResult& result, const CommonOptions& common);

/// Writes NAME.json, NAME.csv (NAME-TABLE.csv for further and raw tables) and NAME.html, which
/// carries the pictures, into the folder, which exists. Throws Error(output).
void write_study(const std::filesystem::path& folder, const StudyResult& result,
                 const CommonOptions& common);

/// Writes NAME.html of the folder's NAME.json and its pictures, NAME-*.png. Throws Error(input) or
/// Error(output).
void write_study_page(const std::filesystem::path& folder, const std::string& name);

}  // namespace relume
