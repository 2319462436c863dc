#pragma once

#include <span>
#include <string>

namespace relume {

/// A file within a page.
struct PageFile {
  std::string name;   ///< letters, digits, '-', '_' and '.'
  std::string bytes;  ///< PNG
};

/// One self-contained HTML page that shows a study's JSON document (docs/study.schema.json): plots,
/// tables and pictures, without a network. `title` and names are plain text.
std::string make_page(const std::string& title, const std::string& json,
                      std::span<const PageFile> pictures);

/// Bytes as base64 (RFC 4648), padded.
std::string encode_base64(const std::string& bytes);

}  // namespace relume
