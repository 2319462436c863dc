#include "viewer/commands/study_files.h"

#include <fmt/format.h>

#include <cctype>

#include "core/base/file.h"
#include "viewer/study/page.h"

namespace relume {
namespace {

FigureTable list_pictures(const StudyResult& result) {
  FigureTable table{"pictures", {}};
  for (const StudyPicture& picture : result.pictures) {
    table.rows.push_back({{"set", picture.set},
                          {"name", picture.name},
                          {"about", picture.about},
                          {"file", picture.file},
                          {"width", int64_t{picture.width}},
                          {"height", int64_t{picture.height}}});
  }
  return table;
}

}  // namespace

std::string file_part(const std::string& name) {
  std::string part = name;
  for (char& letter : part) {
    if (std::isalnum(static_cast<unsigned char>(letter)) == 0 && letter != '_' && letter != '.') {
      letter = '-';
    }
  }
  return part;
}

std::string format_study(const StudyResult& result, const CommonOptions& common) {
  std::vector<FigureTable> tables = result.tables;
  if (!result.pictures.empty()) tables.push_back(list_pictures(result));
  return format_tables("relume-study-" + result.name + "-1", common, tables);
}

void write_study(const std::filesystem::path& folder, const StudyResult& result,
                 const CommonOptions& common) {
  for (const auto* tables : {&result.tables, &result.raw}) {
    for (const FigureTable& table : *tables) {
      const std::string suffix = table.name == "rows" ? "" : "-" + table.name;
      write_file_atomic(folder / (result.name + suffix + ".csv"), format_csv(table.rows));
    }
  }
  const std::string json = format_study(result, common);
  write_file_atomic(folder / (result.name + ".json"), json);
  constexpr uint64_t max_bytes = uint64_t{1} << 30;
  std::vector<PageFile> files;
  for (const StudyPicture& picture : result.pictures) {
    files.push_back({picture.file, read_text_file(folder / picture.file, max_bytes)});
  }
  write_file_atomic(folder / (result.name + ".html"),
                    make_page("Relume: " + result.name, json, files));
}

}  // namespace relume
