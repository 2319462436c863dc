#include "viewer/study/page.h"

#include "viewer/study/page_parts.h"

namespace relume {
namespace {

/// Nothing in the text can end the script element that it stands in.
std::string escape_script(const std::string& json) {
  std::string text;
  text.reserve(json.size());
  for (const char letter : json) {
    if (letter == '<') {
      text += "\\u003c";
    } else {
      text += letter;
    }
  }
  return text;
}

std::string escape_html(const std::string& plain) {
  std::string text;
  for (const char letter : plain) {
    text += letter == '<' ? "&lt;" : letter == '&' ? "&amp;" : std::string(1, letter);
  }
  return text;
}

std::string list_files(std::span<const PageFile> pictures) {
  std::string text = "{";
  for (const PageFile& picture : pictures) {
    if (text.size() > 1) text += ",\n";
    text += '"' + picture.name + "\":\"data:image/png;base64," + encode_base64(picture.bytes) + '"';
  }
  return text + "}";
}

}  // namespace

std::string encode_base64(const std::string& bytes) {
  constexpr std::string_view letters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t j = 0; j < 3; ++j) {
      bits = bits << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0u);
    }
    for (size_t j = 0; j < 4; ++j) {
      text += i + j > bytes.size() ? '=' : letters[bits >> (18 - 6 * j) & 63];
    }
  }
  return text;
}

std::string make_page(const std::string& title, const std::string& json,
                      std::span<const PageFile> pictures) {
  const PageParts& parts = page_parts;
  std::string text;
  text += "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  text += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  text += "<link rel=\"icon\" href=\"data:,\">\n<title>" + escape_html(title) + "</title>\n";
  text.append("<style>\n").append(parts.style).append("</style>\n</head>\n<body>\n");
  text += "<main id=\"page\"></main>\n<script type=\"application/json\" id=\"study\">\n";
  text += escape_script(json) + "</script>\n<script type=\"application/json\" id=\"files\">\n";
  text += list_files(pictures) + "\n</script>\n";
  text.append("<script>\n").append(parts.plotly).append("</script>\n");
  text.append("<script>\n").append(parts.widgets).append(parts.studies).append("</script>\n");
  return text + "</body>\n</html>\n";
}

}  // namespace relume
