#include "viewer/commands/study_files.h"

#include <fmt/format.h>

#include "core/base/file.h"
#include "core/image/image_io.h"
#include "viewer/study/page.h"

namespace relume {
namespace {

std::string picture_file(const StudyResult& result, size_t index) {
  return fmt::format("{}-{:02}.png", result.name, index);
}

FigureTable list_pictures(const StudyResult& result) {
  FigureTable table{"pictures", {}};
  for (size_t i = 0; i < result.pictures.size(); ++i) {
    const StudyPicture& picture = result.pictures[i];
    table.rows.push_back({{"set", picture.set},
                          {"name", picture.name},
                          {"about", picture.about},
                          {"file", picture_file(result, i)},
                          {"width", int64_t{picture.image.width}},
                          {"height", int64_t{picture.image.height}}});
  }
  return table;
}

}  // namespace

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
  std::vector<std::string> files;
  for (size_t i = 0; i < result.pictures.size(); ++i) {
    files.push_back(picture_file(result, i));
    write_png(folder / files.back(), result.pictures[i].image);
  }
  write_file_atomic(folder / (result.name + ".json"), format_study(result, common));
  write_study_page(folder, result.name, files);
}

void write_study_page(const std::filesystem::path& folder, const std::string& name,
                      const std::vector<std::string>& files) {
  constexpr uint64_t max_bytes = uint64_t{1} << 30;
  std::vector<PageFile> pictures;
  for (const std::string& file : files) {
    pictures.push_back({file, read_text_file(folder / file, max_bytes)});
  }
  write_file_atomic(
      folder / (name + ".html"),
      make_page("Relume: " + name, read_text_file(folder / (name + ".json"), max_bytes), pictures));
}

}  // namespace relume
