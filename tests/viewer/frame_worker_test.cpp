// The window's frames, without the window.
#include "apps/viewer/frame_worker.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

#include <gmock/gmock.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "apps/viewer/mask_painter.h"
#include "apps/viewer/overlay.h"
#include "calib/camera_pose.h"
#include "datasets/sequence.h"
#include "datasets/site_file.h"
#include "scene/image_io.h"
#include "session/sequence_session.h"
#include "sunmodel/time_text.h"
#include "tests/calib/marker_scene.h"
#include "tests/scene/shell.h"
#include "tests/viewer/coarse_courtyard.h"
#include "tests/viewer/worker_driver.h"

namespace pleinair::frame_worker_test {
namespace {

using testing::HasSubstr;

std::size_t OverlayNamed(const std::string& name) {
  for (std::size_t i = 0; i < Overlays().size(); ++i) {
    if (name == Overlays()[i].name) return i;
  }
  throw std::invalid_argument(name);
}

class Worker : public testing::Test {
 protected:
  CourtyardCopy copy_;
};

TEST_F(Worker, ShowsWhatASessionGives) {
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  EXPECT_EQ(driver.site->frames, 6);
  EXPECT_FALSE(driver.site->is_live);
  EXPECT_EQ(driver.frame->Index(), 0);
  EXPECT_TRUE(driver.frame->IsComplete());
  SequenceSession session(CoarseOptions(copy_.Path()));
  const SessionStep step = session.Next().value();
  EXPECT_TRUE(driver.frame->shown.pixels == session.Show(step).pixels);
}

TEST_F(Worker, SeeksBackAndForth) {
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  for (const int index : {4, 1, 5}) {
    driver.request.seek_frame = index;
    ++driver.request.seeks;
    ASSERT_TRUE(
        driver.ReachFrame([&](const ViewedFrame& frame) { return frame.Index() == index; }));
    EXPECT_TRUE(driver.frame->Succeeded());
  }
  EXPECT_THAT(driver.shown, testing::ElementsAre(0, 4, 1, 5));
}

TEST_F(Worker, PlaysInOrderAndAroundOnlyWhereItLoops) {
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  driver.request.is_playing = true;
  driver.request.loops = false;
  driver.request.frames_per_second = 240.0;
  ASSERT_TRUE(driver.Reach([&] { return driver.lights.size() >= 6; }));
  ASSERT_TRUE(driver.ReachFrame([](const ViewedFrame& frame) { return frame.Index() == 5; }));
  std::vector<int> lit;
  for (const LightPoint& light : driver.lights) lit.push_back(light.frame);
  EXPECT_THAT(lit, testing::ElementsAre(0, 1, 2, 3, 4, 5));
  // The sun is clear in frame 0 and behind cloud in frame 2.
  EXPECT_GT(driver.lights[0].sun_rgb.y, 10.0 * driver.lights[2].sun_rgb.y);
  EXPECT_TRUE(driver.lights[0].has_stddev);
  // Only once it stands at the end.
  ASSERT_TRUE(driver.Reach([&] { return driver.has_ended; }));
  driver.request.loops = true;
  EXPECT_TRUE(driver.Reach([&] { return driver.lights.size() >= 8; }));
  EXPECT_EQ(driver.lights[6].frame, 0);
}

TEST_F(Worker, AnEditDrawsTheSameFrameAgain) {
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  const Rgb8Image first = driver.frame->shown;
  const glm::dmat4 pose = driver.request.objects.at(0).world_from_object;
  driver.request.objects[0].world_from_object =
      glm::translate(glm::dmat4(1.0), glm::dvec3(0.5, 0.0, 0.0)) * pose;
  const std::int64_t edits = ++driver.request.edits;
  ASSERT_TRUE(
      driver.ReachFrame([&](const ViewedFrame& frame) { return frame.request.edits == edits; }));
  EXPECT_FALSE(driver.frame->shown.pixels == first.pixels);
  EXPECT_EQ(driver.frame->Index(), 0);
  EXPECT_EQ(driver.lights.size(), 1u);  // It is not estimated again.
  driver.request.objects[0].world_from_object = pose;
  ++driver.request.edits;
  ASSERT_TRUE(driver.ReachFrame(
      [&](const ViewedFrame& frame) { return frame.request.edits == edits + 1; }));
  EXPECT_TRUE(driver.frame->shown.pixels == first.pixels);
}

// Two frames a tenth of a second apart, between which the object is in motion.
class WorkerInMotion : public Worker {
 protected:
  void SetUp() override {
    std::ifstream file(copy_ / "sequence.json");
    std::string text{std::istreambuf_iterator<char>(file), {}};
    const std::string second = "\"2005-06-21T08:18:00Z\"";
    ASSERT_NE(text.find(second), std::string::npos);
    text.replace(text.find(second), second.size(), "\"2005-06-21T07:52:00.1Z\"");
    std::ofstream(copy_ / "sequence.json") << text;
  }

  static void MoveAndGoOn(ViewRequest& request) {
    request.objects[0].world_from_object =
        glm::translate(glm::dmat4(1.0), glm::dvec3(0.1, 0.0, 0.0)) *
        request.objects[0].world_from_object;
    ++request.edits;
    request.seek_frame = 1;
    ++request.seeks;
  }

  Rgb8Image ShownAtOnce(const std::vector<VirtualObjectEntry>& objects) {
    SequenceSession session(CoarseOptions(copy_.Path()));
    session.Next();
    session.SetObjects(objects);
    return session.Show(session.Next().value());
  }
};

TEST_F(WorkerInMotion, WhatIsLeftCoarseIsDrawnAgain) {
  ViewCommandOptions options = CoarseOptions(copy_.Path());
  WorkerDriver driver(options);
  ASSERT_TRUE(driver.Open());
  MoveAndGoOn(driver.request);
  ASSERT_TRUE(driver.ReachFrame(
      [](const ViewedFrame& frame) { return frame.Index() == 1 && frame.IsComplete(); }));
  EXPECT_TRUE(driver.frame->shown.pixels == ShownAtOnce(driver.request.objects).pixels);

  options.light_in_steps = true;
  SequenceSession in_steps(options);
  in_steps.Next();
  in_steps.SetObjects(driver.request.objects);
  EXPECT_TRUE(in_steps.Next()->result->is_light_coarse);
}

TEST_F(WorkerInMotion, IsDrawnCompleteWhilePlayingWhereThatIsWanted) {
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  driver.request.is_playing = true;
  driver.request.frames_per_second = 1e-3;  // No other frame follows.
  MoveAndGoOn(driver.request);
  ASSERT_TRUE(driver.ReachFrame(
      [](const ViewedFrame& frame) { return frame.Index() == 1 && !frame.IsComplete(); }));
  driver.request.wants_complete = true;
  ASSERT_TRUE(driver.ReachFrame([](const ViewedFrame& frame) { return frame.IsComplete(); }));
  EXPECT_EQ(driver.frame->Index(), 1);
  EXPECT_TRUE(driver.frame->shown.pixels == ShownAtOnce(driver.request.objects).pixels);
}

TEST_F(Worker, WithAnotherObjectThePictureIsDrawnAgainToo) {
  ViewCommandOptions options = CoarseOptions(copy_.Path());
  ObjectLightOptions& light = options.pipeline.object_light;
  light.in_motion.rays_at_first = light.gather.rays_per_receiver / 2;
  WorkerDriver driver(options);
  ASSERT_TRUE(driver.Open());
  VirtualObjectEntry second = driver.request.objects[0];
  second.world_from_object =
      glm::translate(glm::dmat4(1.0), glm::dvec3(0.5, 0.5, 0.0)) * second.world_from_object;
  driver.request.objects.push_back(second);
  const std::int64_t edits = ++driver.request.edits;
  ASSERT_TRUE(driver.ReachFrame([&](const ViewedFrame& frame) {
    return frame.request.edits == edits && frame.IsComplete();
  }));
}

TEST_F(Worker, ADraggedObjectsPicturesAreFollowedByACompleteOne) {
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  driver.request.is_dragging = true;
  ++driver.request.edits;
  ASSERT_TRUE(driver.ReachFrame([](const ViewedFrame& frame) { return frame.IsQuick(); }));
  driver.request.is_dragging = false;
  ASSERT_TRUE(driver.ReachFrame([](const ViewedFrame& frame) { return frame.IsComplete(); }));
  EXPECT_EQ(driver.frame->request.edits, driver.request.edits);
}

TEST_F(Worker, AnObjectThatCannotBeReadIsANote) {
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  const Rgb8Image before = driver.frame->shown;
  driver.request.objects.push_back({copy_ / "none.obj", glm::dmat4(1.0)});
  const std::int64_t edits = ++driver.request.edits;
  ASSERT_TRUE(
      driver.ReachFrame([&](const ViewedFrame& frame) { return frame.request.edits == edits; }));
  EXPECT_THAT(driver.notes, testing::Contains(HasSubstr("none.obj")));
  EXPECT_TRUE(driver.frame->shown.pixels == before.pixels);
  EXPECT_EQ(driver.failure, "");
}

TEST_F(Worker, ASettingThatDoesNotHoldIsANoteAndAllGoesOn) {
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  const Rgb8Image before = driver.frame->shown;
  const std::int64_t number = driver.frame->number;
  for (const char* setting :
       {"light.samples=many", "no.such.setting=1", "light.samples", "source=fisheye"}) {
    driver.request.settings = {setting};
    ++driver.request.settings_changes;
    const std::size_t notes = driver.notes.size();
    ASSERT_TRUE(driver.Reach([&] { return driver.notes.size() > notes; })) << setting;
    EXPECT_EQ(driver.notes.back().find('\n'), std::string::npos) << driver.notes.back();
  }
  EXPECT_EQ(driver.frame->number, number);
  driver.request.is_dragging = true;  // Drawn by the session that there was.
  ASSERT_TRUE(driver.ReachFrame([](const ViewedFrame& frame) { return frame.IsQuick(); }));
  driver.request.is_dragging = false;
  ASSERT_TRUE(driver.ReachFrame([](const ViewedFrame& frame) { return frame.IsComplete(); }));
  EXPECT_EQ(driver.sites, 1);
  EXPECT_TRUE(driver.frame->shown.pixels == before.pixels);
  EXPECT_EQ(driver.failure, "");
}

TEST_F(Worker, ASettingIsAppliedToTheFrameThatIsShown) {
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  driver.request.seek_frame = 3;
  ++driver.request.seeks;
  ASSERT_TRUE(driver.ReachFrame([](const ViewedFrame& frame) { return frame.Index() == 3; }));
  const Rgb8Image before = driver.frame->shown;
  const std::int64_t number = driver.frame->number;
  driver.request.settings = {"weather=overcast"};
  ++driver.request.settings_changes;
  ASSERT_TRUE(driver.ReachFrame([&](const ViewedFrame& frame) { return frame.number > number; }))
      << testing::PrintToString(driver.notes);
  EXPECT_EQ(driver.frame->Index(), 3);
  EXPECT_EQ(driver.sites, 2);
  EXPECT_FALSE(driver.frame->shown.pixels == before.pixels);
}

TEST_F(Worker, WhatPanelsAskForComesAlong) {
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  EXPECT_TRUE(driver.frame->overlay.Empty());
  EXPECT_FALSE(driver.frame->histogram);
  EXPECT_FALSE(driver.frame->environment);
  driver.request.wants_histogram = true;
  driver.request.wants_environment = true;
  driver.request.wants_probes = true;
  driver.request.overlay = OverlayNamed("normals");
  ASSERT_TRUE(driver.ReachFrame([](const ViewedFrame& frame) { return !frame.overlay.Empty(); }));
  const PictureHistogram& histogram = driver.frame->histogram.value();
  for (std::size_t channel = 0; channel < 3; ++channel) {
    int pixels = 0;
    for (const auto& code : histogram.counts) pixels += code[channel];
    EXPECT_EQ(pixels, 480 * 360);
  }
  EXPECT_EQ(histogram.pixels, 480 * 360);
  EXPECT_EQ(driver.frame->environment.value().width, 2 * driver.frame->environment->height);
  EXPECT_EQ(driver.frame->balls.size(), 1u);  // Without probes: where the environment is.
  // The paving in the foreground faces up; the first row is sky.
  EXPECT_EQ(driver.frame->overlay.At(240, 340), glm::u8vec4(128, 128, 255, 255));
  EXPECT_EQ(driver.frame->overlay.At(240, 0), kNoColour);
  EXPECT_EQ(driver.lights.size(), 1u);  // Nothing of it is estimated again.
}

TEST_F(Worker, EachOverlayHasThePicturesSize) {
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  std::set<std::vector<std::uint8_t>> pictures;
  for (std::size_t i = 0; i < Overlays().size(); ++i) {
    SCOPED_TRACE(Overlays()[i].name);
    driver.request.overlay = i;
    const std::int64_t number = driver.frame->number;
    ASSERT_TRUE(driver.ReachFrame([&](const ViewedFrame& frame) { return frame.number > number; }));
    const Rgba8Image& overlay = driver.frame->overlay;
    EXPECT_EQ(overlay.width, driver.frame->shown.width);
    EXPECT_EQ(overlay.height, driver.frame->shown.height);
    std::vector<std::uint8_t> bytes;
    for (const glm::u8vec4& pixel : overlay.pixels) {
      for (int c = 0; c < 4; ++c) bytes.push_back(pixel[c]);
    }
    EXPECT_TRUE(pictures.insert(bytes).second);
  }
}

TEST_F(Worker, ExposureChangesWhatIsShownAlone) {
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  const auto mean = [&] {
    double sum = 0.0;
    for (const glm::u8vec3& pixel : driver.frame->shown.pixels) sum += pixel.x + pixel.y + pixel.z;
    return sum;
  };
  const double before = mean();
  driver.request.exposure_stops = -2.0;
  const std::int64_t number = driver.frame->number;
  ASSERT_TRUE(driver.ReachFrame([&](const ViewedFrame& frame) { return frame.number > number; }));
  EXPECT_LT(mean(), 0.75 * before);
  EXPECT_EQ(driver.lights.size(), 1u);
}

TEST_F(Worker, AFrameThatCannotBeReadIsShownAsFailed) {
  std::filesystem::remove(copy_ / "frames/000001.exr");
  WorkerDriver driver(CoarseOptions(copy_.Path()));
  ASSERT_TRUE(driver.Open());
  driver.request.seek_frame = 1;
  ++driver.request.seeks;
  ASSERT_TRUE(driver.ReachFrame([](const ViewedFrame& frame) { return frame.Index() == 1; }));
  EXPECT_FALSE(driver.frame->Succeeded());
  ASSERT_TRUE(driver.Reach([&] { return driver.lights.size() == 2; }));
  EXPECT_TRUE(driver.lights[1].failed);
  driver.request.seek_frame = 2;
  ++driver.request.seeks;
  ASSERT_TRUE(driver.ReachFrame([](const ViewedFrame& frame) { return frame.Index() == 2; }));
  EXPECT_TRUE(driver.frame->Succeeded());
}

// Poses from outside, as `run --poses` takes them: each frame's camera is where they say, also when
// it is gone back to.
TEST_F(Worker, FollowsPosesFromOutside) {
  const Sequence sequence = ReadSequence(copy_.Path());
  const auto pose_of = [&](std::size_t frame) {
    const glm::dvec3 step(0.02 * static_cast<double>(frame), 0.0, 0.0);
    return glm::translate(glm::dmat4(1.0), step) * sequence.CameraOfFrame(0).camera_from_world;
  };
  std::ofstream lines(copy_ / "poses.jsonl");
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    nlohmann::json line;
    line["time_utc"] = FormatUtcTime(sequence.frames[i].time);
    line["camera_from_world"] = JsonOf(pose_of(i));
    lines << line.dump() << "\n";
  }
  lines.close();
  ViewCommandOptions options = CoarseOptions(copy_.Path());
  options.poses = copy_ / "poses.jsonl";
  WorkerDriver driver(options);
  ASSERT_TRUE(driver.Open());
  EXPECT_TRUE(driver.site->camera_moves);
  for (const int index : {0, 3, 1}) {
    driver.request.seek_frame = index;
    ++driver.request.seeks;
    ASSERT_TRUE(
        driver.ReachFrame([&](const ViewedFrame& frame) { return frame.Index() == index; }));
    ASSERT_TRUE(driver.frame->Succeeded());
    const glm::dmat4 expected = pose_of(static_cast<std::size_t>(index));
    const glm::dmat4& found = driver.frame->step.frame->camera.camera_from_world;
    for (int c = 0; c < 4; ++c) EXPECT_LT(glm::distance(found[c], expected[c]), 1e-9) << index;
  }
  // What is picked of a camera that stands still is not for this one.
  EXPECT_THAT(MaskPainter(driver.site).WhyNot(), HasSubstr("a camera that stands still"));
  // A pipe gives them once, and the site may be read again.
  std::filesystem::remove(options.poses);
  driver.request.settings = {"pose_track.hold_s=0.1"};
  ++driver.request.settings_changes;
  const std::int64_t number = driver.frame->number;
  ASSERT_TRUE(driver.Reach([&] { return driver.sites == 2 || !driver.notes.empty(); }));
  ASSERT_TRUE(driver.ReachFrame([&](const ViewedFrame& frame) { return frame.number > number; }))
      << testing::PrintToString(driver.notes);
  const glm::dmat4& again = driver.frame->step.frame->camera.camera_from_world;
  EXPECT_LT(glm::distance(again[3], pose_of(1)[3]), 1e-9);
}

// Its frames are made before the session that cannot be: those of the last session go on.
TEST_F(Worker, ACamerasFramesGoOnWhereASessionCannotBeMade) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers do not load behind the stand-in";
#endif
  constexpr const char* kBehindStandIn = "PLEINAIR_TEST_BEHIND_STAND_IN";
  if (std::getenv(kBehindStandIn) == nullptr) {
    const Ended ended =
        Shell(std::string(PLEINAIR_STAND_IN) + " " + copy_.Path().string() + " --loop 0 -- env " +
              kBehindStandIn + "=1 " + std::filesystem::read_symlink("/proc/self/exe").string() +
              " --gtest_filter=Worker.ACamerasFramesGoOnWhereASessionCannotBeMade");
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    return;
  }
  ViewCommandOptions options = CoarseOptions(copy_.Path());
  options.input = "/dev/video90";
  options.camera.exposure_s = 0.01;
  options.camera.gain = 100.0;
  options.camera.white_balance_k = 5000;
  options.camera.frames_per_second = 10.0;
  WorkerDriver driver(options);
  ASSERT_TRUE(driver.Open());
  driver.request.is_playing = true;
  driver.request.effects.threshold_code_values = -1.0;
  ++driver.request.settings_changes;
  ASSERT_TRUE(driver.Reach([&] {
    return std::any_of(driver.notes.begin(), driver.notes.end(), [](const std::string& note) {
      return note.find("threshold_code_values") != std::string::npos;
    });
  })) << testing::PrintToString(driver.notes);
  driver.request.effects = options.pipeline.effects;
  for (int i = 0; i < 5; ++i) {
    const int last = driver.frame->Index();
    ASSERT_TRUE(driver.ReachFrame([&](const ViewedFrame& frame) { return frame.Index() > last; }));
    ASSERT_TRUE(driver.frame->Succeeded());
  }
  EXPECT_EQ(driver.sites, 1);
}

// Poses from markers in the pictures, as `run --markers` takes them.
TEST_F(Worker, FollowsMarkers) {
  const Sequence sequence = ReadSequence(copy_.Path());
  const MarkerBoard board = RoomBoard();
  const auto pose_of = [](int frame) {
    return LookAt({0.3 + 0.02 * frame, -1.6, 1.1}, {0.0, 0.2, 0.1});
  };
  std::ofstream(copy_ / "board.json") << MarkerBoardText(board);
  EditSiteFile(copy_.Path(), [&](nlohmann::ordered_json& json) {
    nlohmann::ordered_json frames = nlohmann::ordered_json::array();
    for (int i = 0; i < 2; ++i) {
      const Gray8Image seen = RenderMarkers(board, sequence.intrinsics, pose_of(i));
      Rgb8Image picture(seen.width, seen.height);
      for (std::size_t k = 0; k < seen.pixels.size(); ++k) {
        picture.pixels[k] = glm::u8vec3(seen.pixels[k]);
      }
      const std::string name = "frames/markers" + std::to_string(i) + ".png";
      WritePng(copy_ / name, picture);
      frames.push_back(
          {{"image_ldr", name}, {"time_utc", "2005-06-21T09:50:0" + std::to_string(i) + "Z"}});
    }
    json["frames"] = frames;
    json["camera"].erase("camera_from_world");
  });
  ViewCommandOptions options = CoarseOptions(copy_.Path());
  options.frames = FrameKind::kLdr;
  options.markers = copy_ / "board.json";
  WorkerDriver driver(options);
  ASSERT_TRUE(driver.Reach([&] { return driver.frame || !driver.failure.empty(); }));
  ASSERT_EQ(driver.failure, "");
  EXPECT_TRUE(driver.site->camera_moves);
  for (const int index : {1, 0}) {
    driver.request.seek_frame = index;
    ++driver.request.seeks;
    ASSERT_TRUE(
        driver.ReachFrame([&](const ViewedFrame& frame) { return frame.Index() == index; }));
    ASSERT_TRUE(driver.frame->step.frame);
    const Camera& camera = driver.frame->step.frame->camera;
    EXPECT_LT(RotationBetweenRad(camera.camera_from_world, pose_of(index)), 0.005) << index;
    const glm::dvec3 eye_m(glm::inverse(pose_of(index))[3]);
    EXPECT_LT(glm::distance(camera.CentreWorldM(), eye_m), 0.01) << index;
  }
}

TEST_F(Worker, ASequenceThatIsMissingIsAFailureOfOneLine) {
  WorkerDriver driver(CoarseOptions(copy_ / "none"));
  ASSERT_TRUE(driver.Reach([&] { return !driver.failure.empty(); }));
  EXPECT_THAT(driver.failure, HasSubstr("none"));
  EXPECT_EQ(driver.failure.find('\n'), std::string::npos);
  EXPECT_FALSE(driver.site);
}

// The window may be closed at any time: while it prepares, and before it has asked for anything.
TEST_F(Worker, EndsWhileItPrepares) {
  const TemporaryFolder empty_cache;
  ViewCommandOptions options = CoarseOptions(copy_.Path());
  options.cache = empty_cache.Path();
  {
    WorkerDriver driver(options);
    EXPECT_TRUE(driver.Reach([&] { return !driver.stages.empty(); }));
    EXPECT_FALSE(driver.site);
  }
  const WorkerDriver at_once(options);
}

}  // namespace
}  // namespace pleinair::frame_worker_test
