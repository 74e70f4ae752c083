#include "apps/video_file.h"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/videoio.hpp>

#include "tests/scene/file_size_limit.h"
#include "tests/scene/temporary_folder.h"
#include "tests/session/command_folder.h"

namespace pleinair::video_file_test {
namespace {

class VideoFileTest : public CommandFolder {};

Rgb8Image Plain(int width, int height, int grey) {
  return {width, height, glm::u8vec3(static_cast<glm::uint8>(grey))};
}

TEST_F(VideoFileTest, HoldsTheFramesInTheirOrder) {
  const std::filesystem::path path = folder_ / "composite.mp4";
  VideoFile video(path, 5.0);
  for (int i = 0; i < 10; ++i) video.Add(Plain(65, 48, 20 + 20 * i));
  EXPECT_FALSE(std::filesystem::exists(path));  // Not before it is complete.
  video.Finish();

  cv::VideoCapture read(path.string());
  ASSERT_TRUE(read.isOpened());
  EXPECT_NEAR(read.get(cv::CAP_PROP_FPS), 5.0, 1e-3);
  cv::Mat frame;
  int count = 0;
  for (; read.read(frame); ++count) {
    EXPECT_EQ(frame.size(), cv::Size(66, 48));  // 65 made even.
    // A lossy codec of plain frames: a few code values.
    EXPECT_NEAR(cv::mean(frame)[1], 20 + 20 * count, 4.0);
  }
  EXPECT_EQ(count, 10);
}

TEST_F(VideoFileTest, IsShownAtItsRate) {
  const std::filesystem::path path = folder_ / "composite.mp4";
  for (const double rate : {0.1, 15.0, 24.0 / 1.001, 29.97, 30.0, 60.0 / 1.001, 240.0}) {
    for (const int count : {1, 7}) {
      VideoFile video(path, rate);
      for (int i = 0; i < count; ++i) video.Add(Plain(32, 32, 100));
      video.Finish();
      cv::VideoCapture read(path.string());
      EXPECT_NEAR(read.get(cv::CAP_PROP_FPS) / rate, 1.0, 1e-4) << rate << " " << count;
      EXPECT_EQ(read.get(cv::CAP_PROP_FRAME_COUNT), count);
    }
  }
}

TEST_F(VideoFileTest, IsWrittenWhereAFolderIsNamedByATime) {
  const std::filesystem::path folder = folder_ / "2026-05-01T10:00:00Z";
  std::filesystem::create_directory(folder);
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder_);
  VideoFile video(folder.filename() / "composite.mp4", 10.0);
  video.Add(Plain(32, 32, 100));
  video.Finish();
  std::filesystem::current_path(before);
  EXPECT_TRUE(std::filesystem::exists(folder / "composite.mp4"));
}

TEST_F(VideoFileTest, LeavesNothingUnlessFinished) {
  {
    VideoFile video(folder_ / "composite.mp4", 10.0);
    video.Add(Plain(32, 32, 100));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
  VideoFile empty(folder_ / "composite.mp4", 10.0);
  empty.Finish();
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

// An MP4's index comes last.
TEST_F(VideoFileTest, LeavesNothingWhereItsEndCannotBeWritten) {
  const std::string older = "the one before";
  const std::filesystem::path path = Write("composite.mp4", older);
  {
    VideoFile video(path, 10.0);
    for (int i = 0; i < 5; ++i) video.Add(Plain(32, 32, 100));
    const FileSizeLimit limit(std::filesystem::file_size(folder_ / "composite.partial.mp4"));
    EXPECT_THROW(video.Finish(), std::runtime_error);
  }
  EXPECT_EQ(ContentOf(path), older);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "composite.partial.mp4"));
}

TEST_F(VideoFileTest, RefusesAPictureOfAnotherSize) {
  VideoFile video(folder_ / "composite.mp4", 10.0);
  video.Add(Plain(32, 32, 100));
  EXPECT_THROW(video.Add(Plain(32, 34, 100)), std::runtime_error);
  VideoFile nowhere(folder_ / "missing" / "composite.mp4", 10.0);
  EXPECT_THROW(nowhere.Add(Plain(32, 32, 100)), std::runtime_error);
}

}  // namespace
}  // namespace pleinair::video_file_test
