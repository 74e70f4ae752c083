#include "apps/message_text.h"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace pleinair::message_text_test {
namespace {

TEST(MessageText, LeavesPrintableTextAsItIs) {
  EXPECT_EQ(MessageText(""), "");
  EXPECT_EQ(MessageText("käse/日本/😀: 1\" °"), "käse/日本/😀: 1\" °");
}

// Escape sequences could turn a terminal's colours, title or keys.
TEST(MessageText, EscapesControlCharactersAndWhatIsNoUtf8) {
  EXPECT_EQ(MessageText("a\x1b[31m\nb\r\tc\x7f"), "a\\x1b[31m\\x0ab\\x0d\\x09c\\x7f");
  EXPECT_EQ(MessageText(std::string("\0x", 2)), "\\x00x");
  EXPECT_EQ(MessageText("\xc2\x9b"
                        "31m"),
            "\\xc2\\x9b31m");  // C1: the same as ESC [.
  EXPECT_EQ(MessageText("\x9b|\xff|\xc3|\xe2\x82|\xc0\xaf|\xf5\x80\x80\x80"),
            "\\x9b|\\xff|\\xc3|\\xe2\\x82|\\xc0\\xaf|\\xf5\\x80\\x80\\x80");
}

TEST(MessageText, IsCut) {
  const std::string cut = MessageText(std::string(5'000'000, 'a') + "b");
  EXPECT_LT(cut.size(), 2100u);
  EXPECT_TRUE(cut.ends_with("a... (4998001 more bytes)")) << cut.substr(1990);
  EXPECT_LT(MessageText(std::string(5'000'000, '\n')).size(), 2100u);
}

TEST(OutputText, KeepsLinesAndEscapesOtherControlCharacters) {
  EXPECT_EQ(OutputText("ä\t1\n日本\t2\n"), "ä\t1\n日本\t2\n");
  EXPECT_EQ(OutputText("a\x1b[31m\r\x7f\xc2\x9b|\xff|\xc2|\xe2\x82"),
            "a\\u001b[31m\\u000d\\u007f\\u009b|\\xff|\\xc2|\\xe2\\x82");
  EXPECT_EQ(OutputText(std::string(5000, 'a')).size(), 5000u);
}

TEST(OutputText, LeavesJsonThatReadsBackTheSame) {
  const nlohmann::json document = {{"name", "a\x1b\x7f\xc2\x9b\n\\"}};
  EXPECT_EQ(nlohmann::json::parse(OutputText(document.dump(1))), document);
}

}  // namespace
}  // namespace pleinair::message_text_test
