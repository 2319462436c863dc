#include "viewer/commands/study_files.h"

#include <fmt/format.h>

#include <algorithm>
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

void write_page(const std::filesystem::path& folder, const std::string& name,
                std::span<const std::string> pictures) {
  constexpr uint64_t max_bytes = uint64_t{1} << 30;
  const std::string json = read_text_file(folder / (name + ".json"), max_bytes);
  std::vector<PageFile> files;
  for (const std::string& file : pictures) {
    files.push_back({file, read_text_file(folder / file, max_bytes)});
  }
  write_file_atomic(folder / (name + ".html"), make_page("Relume: " + name, json, files));
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
  write_file_atomic(folder / (result.name + ".json"), format_study(result, common));
  std::vector<std::string> pictures;
  for (const StudyPicture& picture : result.pictures) pictures.push_back(picture.file);
  write_page(folder, result.name, pictures);
}

void write_study_page(const std::filesystem::path& folder, const std::string& name) {
  std::vector<std::string> pictures;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string file = entry.path().filename().string();
    if (file.starts_with(name + "-") && file.ends_with(".png")) pictures.push_back(file);
  }
  std::ranges::sort(pictures);
  write_page(folder, name, pictures);
}

}  // namespace relume
