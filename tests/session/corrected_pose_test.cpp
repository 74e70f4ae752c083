// The bundled courtyard with a camera that stands elsewhere than stated.
#include "session/corrected_pose.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "calib/lens.h"
#include "datasets/sequence.h"
#include "scene/camera.h"
#include "scene/mesh.h"
#include "session/sequence_site.h"
#include "sunmodel/angles.h"

namespace pleinair::corrected_pose_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::filesystem::path kCourtyard = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";

class CorrectedPose : public testing::Test {
 protected:
  CorrectedPose() {
    true_pose_ = sequence_.camera_from_world.value();
    options_.sequence = kCourtyard;
  }

  // Where the statue's foot is in the picture, against where it should be.
  double OffPx() const {
    const glm::dvec4 foot_m = sequence_.virtual_objects.at(0).world_from_object[3];
    const Lens lens(sequence_.intrinsics);
    const auto pixel = [&](const glm::dmat4& pose) {
      return *lens.ProjectToPixel(glm::dvec3(pose * foot_m));
    };
    return glm::distance(pixel(sequence_.CameraOfFrame(0).camera_from_world), pixel(true_pose_));
  }

  SessionOptions options_;
  Sequence sequence_ = ReadSequence(kCourtyard);
  const Mesh mesh_ = LoadSequenceSite(sequence_).model.mesh;
  glm::dmat4 true_pose_;
  // Half a degree down and to the right: 4.6 px.
  const glm::dmat4 turn_ =
      glm::rotate(glm::dmat4(1.0), RadFromDeg(0.7), glm::normalize(glm::dvec3(1.0, -1.0, 0.0)));
};

TEST_F(CorrectedPose, PutsTheObjectWhereItBelongs) {
  sequence_.camera_from_world = turn_ * true_pose_;
  const double stated_px = OffPx();
  ASSERT_GT(stated_px, 3.0);
  EXPECT_THAT(CorrectPose(options_, mesh_, sequence_),
              AllOf(HasSubstr("camera_from_world: the mesh's edges are"),
                    HasSubstr("in 5 frame(s)"),
                    HasSubstr("; objects' places in the picture are known to")));
  EXPECT_LT(OffPx(), stated_px / 3.0);
}

TEST_F(CorrectedPose, StatesNoDeviationOfObjectsOutOfView) {
  sequence_.camera_from_world = turn_ * true_pose_;
  for (VirtualObjectEntry& object : sequence_.virtual_objects) {
    const glm::dvec4 behind_camera_m(0.0, 0.0, -1.0, 1.0);
    object.world_from_object[3] = glm::inverse(true_pose_) * behind_camera_m;
  }
  EXPECT_THAT(CorrectPose(options_, mesh_, sequence_),
              AllOf(HasSubstr("the camera is turned by"), Not(HasSubstr("objects' places"))));
}

// As many recordings state it: in each frame.
TEST_F(CorrectedPose, OfFramesThatStateTheSamePose) {
  sequence_.camera_from_world = turn_ * true_pose_;
  EXPECT_NE(CorrectPose(options_, mesh_, sequence_), "");
  const double corrected_px = OffPx();
  sequence_.camera_from_world.reset();
  for (FrameEntry& frame : sequence_.frames) frame.camera_from_world = turn_ * true_pose_;
  EXPECT_NE(CorrectPose(options_, mesh_, sequence_), "");
  EXPECT_EQ(OffPx(), corrected_px);
}

TEST_F(CorrectedPose, KeepsARightPose) {
  EXPECT_EQ(CorrectPose(options_, mesh_, sequence_), "");
  EXPECT_EQ(sequence_.camera_from_world, true_pose_);
}

TEST_F(CorrectedPose, KeepsAStatedPoseThatItMayNotCorrect) {
  options_.correct_pose = false;
  sequence_.camera_from_world = turn_ * true_pose_;
  EXPECT_EQ(CorrectPose(options_, mesh_, sequence_), "");
  options_.correct_pose = true;
  sequence_.pose_stddev_rad = 0.0;  // Exact.
  EXPECT_EQ(CorrectPose(options_, mesh_, sequence_), "");
  sequence_.pose_stddev_rad = RadFromDeg(0.02);  // As good as picks: not half a degree off.
  EXPECT_EQ(CorrectPose(options_, mesh_, sequence_), "");
  sequence_.pose_stddev_rad.reset();
  // A camera that moves.
  sequence_.frames[1].camera_from_world = true_pose_;
  EXPECT_EQ(CorrectPose(options_, mesh_, sequence_), "");
  EXPECT_EQ(sequence_.camera_from_world, turn_ * true_pose_);
}

// Frames that cannot be read are those of the run to report.
TEST_F(CorrectedPose, FramesThatCannotBeReadAreLeftOut) {
  sequence_.camera_from_world = turn_ * true_pose_;
  for (FrameEntry& frame : sequence_.frames) frame.image = "frames/none.exr";
  EXPECT_EQ(CorrectPose(options_, mesh_, sequence_), "");
  EXPECT_EQ(sequence_.camera_from_world, turn_ * true_pose_);
}

}  // namespace
}  // namespace pleinair::corrected_pose_test
