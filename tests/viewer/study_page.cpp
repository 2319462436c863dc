#include <gtest/gtest.h>

#include <vector>

#include "viewer/study/page.h"

namespace relume {
namespace {

size_t count(const std::string& text, const std::string& part) {
  size_t found = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST(Page, EncodesAsThePublishedExamples) {
  const std::pair<const char*, const char*> examples[] = {{"", ""},
                                                          {"f", "Zg=="},
                                                          {"fo", "Zm8="},
                                                          {"foo", "Zm9v"},
                                                          {"foob", "Zm9vYg=="},
                                                          {"fooba", "Zm9vYmE="},
                                                          {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, encoded] : examples) EXPECT_EQ(encode_base64(plain), encoded);
  EXPECT_EQ(encode_base64("\xff\xfe\x80"), "//6A");
}

TEST(Page, HoldsItsDocumentAndPicturesAndCannotBeBrokenByThem) {
  const std::vector<PageFile> pictures{{"a.png", "foo"}};
  const std::string empty = make_page("study", "{}", {});
  const std::string page =
      make_page("a < b", "{\"name\": \"</script><script>alert(1)\"}", pictures);
  EXPECT_EQ(count(page, "<script"), count(empty, "<script"));
  EXPECT_EQ(count(page, "</script"), count(empty, "</script"));
  EXPECT_NE(page.find("<title>a &lt; b</title>"), std::string::npos);
  EXPECT_NE(page.find("\"a.png\":\"data:image/png;base64,Zm9v\""), std::string::npos);
  EXPECT_EQ(count(page, "src=\"http"), 0u);
}

}  // namespace
}  // namespace relume
