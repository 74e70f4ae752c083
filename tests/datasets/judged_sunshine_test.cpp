#include "datasets/judged_sunshine.h"

#include <gmock/gmock.h>

#include "tests/datasets/sequence_fixture.h"

namespace pleinair::judged_sunshine_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class JudgedSunshine : public SequenceFolder {
 protected:
  // A sequence of three frames.
  Sequence ThreeFrames() {
    Sequence sequence;
    sequence.folder = folder_;
    sequence.frames.resize(3);
    return sequence;
  }
  void Judge(const std::string& sun) {
    Write(folder_ / "judged.json",
          R"({"format": "pleinair-judged", "version": 1, "note": "by eye", "sun": )" + sun + "}");
  }
  std::string JudgmentsRefusal() {
    try {
      ReadJudgedSunshine(ThreeFrames());
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "accepted";
  }
};

TEST_F(JudgedSunshine, IsUnknownWhereNobodyJudged) {
  EXPECT_THAT(ReadJudgedSunshine(ThreeFrames()),
              ElementsAre(std::nullopt, std::nullopt, std::nullopt));
}

TEST_F(JudgedSunshine, IsOfAllFramesOrOfEach) {
  Judge("\"sun\"");
  EXPECT_THAT(ReadJudgedSunshine(ThreeFrames()), ElementsAre(true, true, true));
  Judge(R"(["none", "unclear", "sun"])");
  EXPECT_THAT(ReadJudgedSunshine(ThreeFrames()), ElementsAre(false, std::nullopt, true));
}

TEST_F(JudgedSunshine, RefusesWhatIsNoJudgment) {
  Judge("\"sunny\"");
  EXPECT_THAT(JudgmentsRefusal(), HasSubstr("judged.json: sun: expected"));
  Judge(R"(["none", "sun"])");
  EXPECT_THAT(JudgmentsRefusal(), HasSubstr("judged.json: sun: expected"));
  Judge(R"(["none", "sun", true])");
  EXPECT_THAT(JudgmentsRefusal(), HasSubstr("judged.json: sun[2]: expected"));
  Write(folder_ / "judged.json", R"({"format": "pleinair-judged", "version": 1, "moon": "full"})");
  EXPECT_THAT(JudgmentsRefusal(), HasSubstr("moon"));
}

}  // namespace
}  // namespace pleinair::judged_sunshine_test
