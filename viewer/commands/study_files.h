#pragma once

#include <filesystem>

#include "core/image/image.h"
#include "viewer/commands/json_output.h"

namespace relume {

/// A picture of a study. Those of one set show the same part of a scene and can be wiped against
/// each other.
struct StudyPicture {
  std::string set;
  std::string name;
  std::string about;  ///< figures to show beside it; may be empty
  DisplayImage image;
};

/// What a study found. The first table is called "rows".
struct StudyResult {
  std::string name;
  std::vector<FigureTable> tables;
  std::vector<StudyPicture> pictures;
  std::vector<FigureTable> raw;  ///< written as CSV alone
};

/// The study's document, see docs/study.schema.json.
std::string format_study(const StudyResult& result, const CommonOptions& common);

/// Writes NAME.json, NAME.csv (NAME-TABLE.csv for further and raw tables), the pictures and
/// NAME.html into the folder, which exists. Throws Error(output).
void write_study(const std::filesystem::path& folder, const StudyResult& result,
                 const CommonOptions& common);

/// Writes NAME.html from the folder's NAME.json and the pictures named in `files`.
void write_study_page(const std::filesystem::path& folder, const std::string& name,
                      const std::vector<std::string>& files);

}  // namespace relume
