// Snapshots of frames, read and run again.
#include "apps/viewer/snapshot.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <glm/gtc/matrix_transform.hpp>

#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "session/sequence_session.h"
#include "tests/viewer/coarse_courtyard.h"
#include "tests/viewer/worker_driver.h"

namespace pleinair::snapshot_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Snapshot : public testing::Test {
 protected:
  SnapshotChoices Choices() const {
    return {driver_.request.objects, options_.stated_settings, driver_.request.effects};
  }

  CourtyardCopy copy_;
  TemporaryFolder out_;
  ViewCommandOptions options_ = CoarseOptions(copy_.Path());
  WorkerDriver driver_{options_};
};

TEST_F(Snapshot, IsASequenceWhoseRunGivesItsComposite) {
  ASSERT_TRUE(driver_.Open());
  const fs::path folder = WriteSnapshot(*driver_.site, *driver_.frame, Choices(), out_.Path());
  EXPECT_EQ(folder, out_ / "snapshot-20050621-075200");
  EXPECT_EQ(out_.FileCount(), 1u);

  const Sequence alone = ReadSequence(folder);
  ASSERT_EQ(alone.frames.size(), 1u);
  EXPECT_EQ(alone.frames[0].time, driver_.frame->Time());
  ASSERT_EQ(alone.virtual_objects.size(), 1u);
  EXPECT_EQ(alone.virtual_objects[0].world_from_object,
            driver_.request.objects[0].world_from_object);

  EXPECT_EQ(ReadDisplayImage(folder / "composite.png").pixels, driver_.frame->shown.pixels);
  SessionOptions again;
  ApplySettings(folder / "settings.txt", again);
  again.sequence = folder;
  again.cache = SharedCache();
  again.lighting = folder / "lighting.jsonl";
  SequenceSession session(again);
  const SessionStep step = session.Next().value();
  ASSERT_TRUE(step.result) << step.result.error().reason;
  EXPECT_EQ(session.Show(step).pixels, driver_.frame->shown.pixels);
}

TEST_F(Snapshot, TakesEffectsOverAsTheyAreSwitched) {
  driver_.request.effects[kAllEffects.front()] = EffectSwitch::kOff;
  driver_.request.effects[kAllEffects.back()] = EffectSwitch::kOn;
  driver_.request.effects.threshold_code_values = 2.5;
  ASSERT_TRUE(driver_.Open());
  const fs::path folder = WriteSnapshot(*driver_.site, *driver_.frame, Choices(), out_.Path());
  const std::string run = ContentOf(folder / "run.txt");
  EXPECT_THAT(run,
              HasSubstr("--effects plan,no-" + std::string(NameOf(kAllEffects.front())) + ","));
  EXPECT_THAT(run, HasSubstr("," + std::string(NameOf(kAllEffects.back())) + " "));
  EXPECT_THAT(ContentOf(folder / "settings.txt"),
              HasSubstr("pipeline.effects.threshold_code_values=2.5\n"));
}

TEST_F(Snapshot, BringsObjectsFromElsewhereAndCountsItsFolders) {
  const TemporaryFolder elsewhere;
  fs::copy_file(copy_ / "object.obj", elsewhere / "statue.obj");
  fs::copy_file(copy_ / "object.mtl", elsewhere / "object.mtl");
  ASSERT_TRUE(driver_.Open());
  SnapshotChoices choices = Choices();
  choices.objects.push_back({elsewhere / "statue.obj", glm::dmat4(1.0)});
  const fs::path first = WriteSnapshot(*driver_.site, *driver_.frame, choices, out_.Path());
  const fs::path second = WriteSnapshot(*driver_.site, *driver_.frame, choices, out_.Path());
  EXPECT_NE(first, second);
  EXPECT_EQ(ReadSequence(second).virtual_objects.at(1).mesh, "objects/statue/statue.obj");
  // The site itself is as it was.
  EXPECT_FALSE(fs::exists(copy_ / "objects"));
}

TEST_F(Snapshot, LeavesNothingBehindWhereItFails) {
  ASSERT_TRUE(driver_.Open());
  SnapshotChoices choices = Choices();
  choices.objects.push_back({copy_ / "none.obj", glm::dmat4(1.0)});
  const auto fails = [&](const fs::path& out) {
    std::string message =
        MessageOf([&] { WriteSnapshot(*driver_.site, *driver_.frame, choices, out); });
    EXPECT_THAT(message, testing::StartsWith("snapshot: "));
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  };
  EXPECT_THAT(fails(out_.Path()), HasSubstr("none.obj"));
  EXPECT_EQ(out_.FileCount(), 0u);
  choices = Choices();
  out_.Write("file", "in the way");
  EXPECT_THAT(fails(out_ / "file"), HasSubstr("file"));
  EXPECT_EQ(out_.FileCount(), 1u);
  fs::remove(copy_ / "scene.obj");
  fails(out_.Path());
  EXPECT_EQ(out_.FileCount(), 1u);
}

}  // namespace
}  // namespace pleinair::snapshot_test
