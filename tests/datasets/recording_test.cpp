#include "datasets/recording/recording.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <set>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/camera_noise.h"
#include "datasets/frame_source.h"
#include "datasets/internal/sampling_mask.h"
#include "datasets/internal/site_frames.h"
#include "datasets/recording/recorder.h"
#include "datasets/recording/site_files.h"
#include "scene/image_io.h"
#include "tests/datasets/made_pictures.h"
#include "tests/datasets/sequence_fixture.h"
#include "tests/scene/file_size_limit.h"

namespace pleinair::recording_test {
namespace {

namespace fs = std::filesystem;
using made_pictures::Frame;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr PixelFormat kRgb{PixelCoding::kRgb};
constexpr PixelFormat kYuyv{PixelCoding::kYuyv};
constexpr PixelFormat kMjpeg{PixelCoding::kMjpeg};
constexpr PixelFormat kGrey{PixelCoding::kGrey};
constexpr PixelFormat kNv12{PixelCoding::kNv12};
constexpr PixelFormat kBayer{PixelCoding::kBayer, 10, false, BayerOrder::kGrbg};

CameraFrame Picture(PixelFormat format, int number) {
  return Frame(format, kWidth, kHeight, number);
}

class RecordingFolder : public SequenceFolder {
 protected:
  void SetUp() override {
    SequenceFolder::SetUp();
    WriteDocument(Everything());
    Write(folder_ / "frames/0.png", "x");
    site_ = ReadSite(folder_, UtcTime{});
    options_.folder = root_ / "recording";
    options_.keep_free_bytes = 0;
  }

  Recording Start(PixelFormat format) {
    return Recording(site_, Picture(format, 0).buffer.layout, options_);
  }

  std::unique_ptr<FrameSource> Play() const {
    return MakeRecordedFrameSource(ReadSequence(options_.folder), FrameKind::kLdr, {});
  }

  // That the recording plays as these pictures, bit for bit.
  void ExpectPlays(const std::vector<CameraFrame>& captured) const {
    const std::unique_ptr<FrameSource> source = Play();
    ASSERT_EQ(source->Count(), static_cast<int>(captured.size()));
    for (const CameraFrame& picture : captured) {
      const auto played = source->Next();
      ASSERT_TRUE(played);
      ASSERT_TRUE(*played) << played->error().reason;
      EXPECT_EQ((*played)->time, picture.time);
      EXPECT_EQ((*played)->units, LightUnits::kRelative);
      const CapturedExposure& exposure = picture.buffer.exposure;
      EXPECT_DOUBLE_EQ((*played)->exposure.value(), *exposure.exposure_s * 100.0 * *exposure.gain);
      const auto codes = DecodeCodes(picture.buffer.bytes, picture.buffer.layout);
      EXPECT_EQ((*played)->codes->pixels, codes.value().pixels);
    }
  }

  std::vector<std::string> NamesIn(const char* folder) const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(options_.folder / folder)) {
      names.push_back(entry.path().filename().string());
    }
    std::ranges::sort(names);
    return names;
  }

  Sequence site_;
  RecordingOptions options_;
};

TEST_F(RecordingFolder, PlaysWhatWasCaptured) {
  for (const PictureStore store : {PictureStore::kRaw, PictureStore::kFfv1}) {
    for (const PixelFormat format : {kRgb, kYuyv, kNv12, kGrey, kMjpeg}) {
      SCOPED_TRACE(NameOf(format));
      fs::remove_all(options_.folder);
      options_.store = store;
      const std::vector<CameraFrame> captured = {
          Picture(format, 0), Picture(format, 1), Picture(format, 2)};
      Recording recording = Start(format);
      for (const CameraFrame& picture : captured) {
        const auto bytes = recording.Add(picture);
        ASSERT_TRUE(bytes) << bytes.error();
        EXPECT_GT(*bytes, 0u);
      }
      // While it is recorded, and after.
      ExpectPlays(captured);
      recording.Finish();
      ExpectPlays(captured);
    }
  }
}

TEST_F(RecordingFolder, KeepsJpegAndRawBytes) {
  for (const auto& [format, ending] : {std::pair(kMjpeg, ".jpg"), std::pair(kBayer, ".raw")}) {
    fs::remove_all(options_.folder);
    const CameraFrame picture = Picture(format, 3);
    Start(format).Add(picture).value();
    std::ifstream file(
        options_.folder / "frames" / (std::string("20260621T000000.099999Z") + ending),
        std::ios::binary);
    const std::string kept((std::istreambuf_iterator<char>(file)), {});
    EXPECT_TRUE(std::ranges::equal(
        kept, picture.buffer.bytes, {}, [](char c) { return static_cast<std::byte>(c); }));
  }
}

TEST_F(RecordingFolder, DevelopsRawPicturesAsTheCameraWould) {
  CameraFrame picture = Picture(kBayer, 0);
  picture.buffer.development = RawDevelopment{60.0, 1000.0, {2.0, 1.0, 1.5}};
  Start(kBayer).Add(picture).value();
  const auto developed =
      Develop(picture.buffer.bytes, picture.buffer.layout, *picture.buffer.development);
  const std::unique_ptr<FrameSource> source = Play();
  const auto played = source->Next();
  ASSERT_TRUE(*played) << played->error().reason;
  EXPECT_EQ((*played)->units, LightUnits::kRelative);
  EXPECT_EQ((*played)->clipped.pixels, developed.value().clipped.pixels);
  EXPECT_GT(std::ranges::count(developed.value().clipped.pixels, 1), 0);
  const auto scale = static_cast<float>(1.0 / (*played)->exposure.value());
  for (std::size_t i = 0; i < developed->signal_rgb.pixels.size(); ++i) {
    ASSERT_EQ((*played)->radiance.pixels[i], developed->signal_rgb.pixels[i] * scale);
  }
}

TEST_F(RecordingFolder, IsACompleteSequenceWithTheSitesFiles) {
  Start(kRgb).Add(Picture(kRgb, 0)).value();
  fs::rename(folder_, root_ / "gone");
  const Sequence sequence = ReadSequence(options_.folder);
  EXPECT_EQ(sequence.name, "recording");
  EXPECT_EQ(sequence.intrinsics.width_px, kWidth);
  // The site's camera has an eighth of the width.
  EXPECT_DOUBLE_EQ(sequence.intrinsics.fx_px, 8.0 * site_.intrinsics.fx_px);
  EXPECT_EQ(sequence.camera_from_world, site_.camera_from_world);
  EXPECT_FALSE(sequence.weather);
  EXPECT_TRUE(fs::exists(options_.folder / "response.json"));
  EXPECT_FALSE(fs::exists(options_.folder / "frames/0.png"));
}

// A mask over the first frame is as true at another resolution, live and recorded.
TEST_F(RecordingFolder, ScalesAMaskOverTheFirstFrame) {
  Gray8Image mask(8, 6, 255);
  mask.At(6, 2) = 0;
  WritePng(folder_ / "mask.png", mask);
  nlohmann::json document = Everything();
  document.erase("environment");
  WriteDocument(document);
  site_ = ReadSite(folder_, UtcTime{});
  const CameraFrame picture = Picture(kRgb, 0);
  Start(kRgb).Add(picture).value();

  const auto played = Play()->Next();
  ASSERT_TRUE(*played) << played->error().reason;
  const auto codes = DecodeCodes(picture.buffer.bytes, picture.buffer.layout);
  FrameEntry taken;
  taken.time = picture.time;
  SetExposure(picture.buffer.exposure, taken);
  const Gray8Image live = SiteFrames(site_, {}).Make(0, taken, codes.value()).unusable;
  EXPECT_EQ((*played)->unusable.pixels, live.pixels);
  site_.diffuse_mask.reset();
  Gray8Image expected = SiteFrames(site_, {}).Make(0, taken, codes.value()).unusable;
  for (int y = 16; y < 24; ++y) {
    for (int x = 48; x < 56; ++x) expected.At(x, y) = kUnusable;
  }
  EXPECT_EQ(live.pixels, expected.pixels);
}

TEST(ScaledMask, KeepsOnlyPixelsThatAreCoveredCompletely) {
  Gray8Image mask(4, 2, 255);
  mask.At(1, 1) = 254;
  EXPECT_THAT(ScaledMask(mask, 2, 1).pixels, ElementsAre(0, 255));
  EXPECT_THAT(ScaledMask(mask, 8, 1).pixels, ElementsAre(255, 255, 0, 0, 255, 255, 255, 255));
  // Pixel 1 of 4 lies in the first and in the second of 3.
  EXPECT_THAT(ScaledMask(mask, 3, 1).pixels, ElementsAre(0, 0, 255));
  EXPECT_THAT(ScaledMask(mask, 4, 2).pixels, ElementsAre(255, 255, 255, 255, 255, 0, 255, 255));
}

TEST_F(RecordingFolder, TakesTheSitesFilesAlone) {
  const auto make = [&](const fs::path& file) {
    fs::create_directories((folder_ / file).parent_path());
    Write(folder_ / file, "x");
  };
  for (const char* file : {"textures/brick.png",
                           "truth/truth.json",
                           "monday/sequence.json",
                           "monday/frames/a.png",
                           "out/lighting.jsonl",
                           "out/composite/000000.png",
                           ".git/config",
                           "judged.json",
                           "events.jsonl",
                           "today/scene.obj"}) {
    make(file);
  }
  fs::create_symlink(root_ / "outside.obj", folder_ / "link.obj");
  EXPECT_THAT(SiteFiles(folder_, folder_ / "today"),
              ElementsAre("environment.exr",
                          "fisheye.json",
                          "mask.png",
                          "object.obj",
                          "response.json",
                          "scene.obj",
                          "textures/brick.png"));
}

TEST_F(RecordingFolder, MayLieInItsSite) {
  options_.folder = folder_ / "recordings/today";
  Start(kRgb).Add(Picture(kRgb, 0)).value();
  EXPECT_FALSE(fs::exists(options_.folder / "recordings"));
  EXPECT_EQ(ReadSequence(options_.folder).frames.size(), 1u);
}

TEST_F(RecordingFolder, NamesPicturesByTimeThoughTheClockIsSteppedBack) {
  Recording recording = Start(kRgb);
  std::vector<CameraFrame> captured = {Picture(kRgb, 30), Picture(kRgb, 31), Picture(kRgb, 32)};
  captured[1].time = captured[0].time;
  captured[2].time = captured[0].time - std::chrono::hours(1);
  for (const CameraFrame& picture : captured) recording.Add(picture).value();
  EXPECT_THAT(NamesIn("frames"),
              ElementsAre("20260620T230000.999990Z.png",
                          "20260621T000000.999990Z-2.png",
                          "20260621T000000.999990Z.png"));
  ExpectPlays(captured);
}

TEST_F(RecordingFolder, LeavesOutPicturesThatCannotBePlayed) {
  Recording recording = Start(kYuyv);
  CameraFrame damaged = Picture(kYuyv, 0);
  damaged.buffer.is_damaged = true;
  EXPECT_THAT(recording.Add(damaged).error(), HasSubstr("reports damage"));
  CameraFrame truncated = Picture(kYuyv, 1);
  truncated.buffer.bytes.resize(100);
  EXPECT_THAT(recording.Add(truncated).error(), HasSubstr("expected 6144 bytes"));
  EXPECT_THAT(recording.Add(Frame(kYuyv, 32, 24, 2)).error(), HasSubstr("expected YUYV 64x48"));
  recording.Add(Picture(kYuyv, 3)).value();
  ExpectPlays({Picture(kYuyv, 3)});
}

TEST_F(RecordingFolder, RefusesWhatItCannotRecord) {
  const auto refusal = [&](PixelFormat format) -> std::string {
    try {
      Start(format);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "accepted";
  };
  options_.store = PictureStore::kFfv1;
  EXPECT_THAT(refusal(kBayer), HasSubstr("expected the store `raw` for SGRBG10"));
  fs::remove_all(options_.folder);
  options_.expected_pictures = 1e12;
  EXPECT_THAT(refusal(kRgb), HasSubstr("recording: expected 4608000000 MB of free space, found"));
  // Nothing is left that the next attempt would be refused for.
  EXPECT_FALSE(fs::exists(options_.folder));
  options_.expected_pictures.reset();
  fs::create_directories(options_.folder);
  Write(options_.folder / "notes.txt", "x");
  EXPECT_THAT(refusal(kRgb), HasSubstr("expected a new folder, or an empty one"));
  EXPECT_EQ(NamesIn(""), std::vector<std::string>{"notes.txt"});
  site_.intrinsics.height_px = 7;
  options_.folder = root_ / "other";
  EXPECT_THAT(refusal(kRgb), HasSubstr("expected the shape of the site's camera, 8x7"));
}

TEST_F(RecordingFolder, PassesOverALineThatWasNotFinished) {
  Start(kRgb).Add(Picture(kRgb, 0)).value();
  const fs::path list = options_.folder / "frames.jsonl";
  std::ifstream in(list);
  std::string line;
  std::getline(in, line);
  for (const std::size_t length : {std::size_t{1}, line.size() / 2, line.size()}) {
    Write(list, line + "\n" + line.substr(0, length));
    ExpectPlays({Picture(kRgb, 0)});
  }
  const auto refusal = [&] {
    try {
      ReadSequence(options_.folder);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  Write(list, line + "\n{\"image_ldr\": 3}\n" + line + "\n");
  EXPECT_THAT(refusal(), HasSubstr("frames.jsonl:2: image_ldr: expected"));
  Write(list, line + "\n" + line.substr(0, 9) + "\n");
  EXPECT_THAT(refusal(), HasSubstr("frames.jsonl:2"));
  Write(list, line);
  EXPECT_THAT(refusal(),
              HasSubstr("frames.jsonl: expected a frame a line, found none: no picture"));
}

// What a child process records until it is killed; it says by a byte that a picture is in it.
[[noreturn]] void RecordForEver(const Sequence& site,
                                PixelFormat format,
                                const RecordingOptions& options,
                                int done) {
  Recording recording(site, Picture(format, 0).buffer.layout, options);
  for (int number = 0;; ++number) {
    if (!recording.Add(Picture(format, number))) _exit(1);
    if (write(done, "x", 1) != 1) _exit(1);
  }
}

TEST_F(RecordingFolder, LosesNothingWhenItIsKilled) {
  struct Way {
    PictureStore store;
    PixelFormat format;
  };
  const Way ways[] = {{PictureStore::kRaw, kRgb},
                      {PictureStore::kRaw, kMjpeg},
                      {PictureStore::kFfv1, kRgb},
                      {PictureStore::kH264, kYuyv}};
  std::mt19937 random(1);
  std::uniform_int_distribution<int> wait_us(0, 60'000);
  int with_pictures = 0;
  for (int kill_number = 0; kill_number < 20; ++kill_number) {
    const Way& way = ways[kill_number % 4];
    fs::remove_all(options_.folder);
    options_.store = way.store;
    int pipe_ends[2] = {};
    ASSERT_EQ(pipe(pipe_ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      try {
        RecordForEver(site_, way.format, options_, pipe_ends[1]);
      } catch (...) {
        _exit(1);
      }
    }
    close(pipe_ends[1]);
    char byte = 0;
    ASSERT_EQ(read(pipe_ends[0], &byte, 1), 1) << "the child has failed";
    int finished = 1;
    usleep(static_cast<useconds_t>(wait_us(random)));
    kill(child, SIGKILL);
    while (read(pipe_ends[0], &byte, 1) == 1) ++finished;
    close(pipe_ends[0]);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));

    const std::unique_ptr<FrameSource> source = Play();
    // One may have been added, and not been reported yet.
    ASSERT_GE(*source->Count(), finished);
    ASSERT_LE(*source->Count(), finished + 1);
    for (int number = 0; number < *source->Count(); ++number) {
      const auto played = source->Next();
      ASSERT_TRUE(*played) << played->error().reason;
      if (way.store == PictureStore::kH264) continue;
      const CapturedBuffer captured = Picture(way.format, number).buffer;
      ASSERT_EQ((*played)->codes->pixels, DecodeCodes(captured.bytes, captured.layout)->pixels);
    }
    with_pictures += finished > 1 ? 1 : 0;
  }
  EXPECT_GT(with_pictures, 10);
}

TEST_F(RecordingFolder, LeavesNoHalfPictureWhereTheDiskFails) {
  for (const PictureStore store : {PictureStore::kRaw, PictureStore::kFfv1}) {
    fs::remove_all(options_.folder);
    options_.store = store;
    Recording recording = Start(kRgb);
    const std::uint64_t bytes = recording.Add(Picture(kRgb, 0)).value();
    recording.Add(Picture(kRgb, 1)).value();
    {
      // Half of the third picture.
      const std::uint64_t before = store == PictureStore::kRaw ? 0 : 2 * bytes;
      const FileSizeLimit limit(before + bytes / 2);
      EXPECT_THROW(recording.Add(Picture(kRgb, 2)).value(), std::runtime_error);
    }
    recording.Finish();
    ExpectPlays({Picture(kRgb, 0), Picture(kRgb, 1)});
    for (const std::string& name : NamesIn(store == PictureStore::kRaw ? "frames" : "video")) {
      EXPECT_FALSE(name.ends_with(".part")) << name;
    }
  }
}

TEST_F(RecordingFolder, SaysThatItsVideoCouldNotBeEnded) {
  options_.store = PictureStore::kFfv1;
  Recording recording = Start(kRgb);
  recording.Add(Picture(kRgb, 0)).value();
  const fs::path video = options_.folder / "video" / NamesIn("video").at(0);
  {
    const FileSizeLimit limit(fs::file_size(video));  // Its index does not fit.
    EXPECT_THROW(recording.Finish(), std::runtime_error);
  }
  ExpectPlays({Picture(kRgb, 0)});
}

TEST_F(RecordingFolder, LeavesNoHalfLineWhereTheDiskFails) {
  Recording recording = Start(kGrey);
  // Grey pictures without detail are smaller than a few lines.
  const auto flat = [](int number) {
    CameraFrame picture = Picture(kGrey, number);
    std::ranges::fill(picture.buffer.bytes, std::byte{7});
    return picture;
  };
  std::vector<CameraFrame> captured;
  {
    const FileSizeLimit limit(1000);
    EXPECT_THROW(
        {
          for (int number = 0; number < 100; ++number) {
            recording.Add(flat(number)).value();
            captured.push_back(flat(number));
          }
        },
        std::runtime_error);
  }
  EXPECT_GT(captured.size(), 1u);
  recording.Add(flat(50)).value();
  captured.push_back(flat(50));
  ExpectPlays(captured);
}

class RecorderFolder : public RecordingFolder {
 protected:
  void Run(const RecorderOptions& options, const std::vector<CameraFrame>& pictures) {
    Recorder recorder(site_, pictures.front().buffer.layout, options, events_);
    for (const CameraFrame& picture : pictures) offered_.push_back(recorder.Offer(picture));
    recorder.Close();
    recorder.AddEvents(events_.TakeAll());
    recorder.Finish();
    status_ = recorder.Status();
  }

  EventLog events_;
  std::vector<bool> offered_;
  RecorderStatus status_;
};

TEST_F(RecorderFolder, WritesAllThatWaits) {
  std::vector<CameraFrame> pictures;
  pictures.reserve(20);
  for (int number = 0; number < 20; ++number) pictures.push_back(Picture(kRgb, number));
  Run({options_}, pictures);
  EXPECT_EQ(status_.written, 20);
  EXPECT_EQ(status_.finished, 20);
  EXPECT_EQ(status_.dropped, 0);
  EXPECT_EQ(status_.stopped, "");
  ExpectPlays(pictures);
}

TEST_F(RecorderFolder, DropsWhatTheDiskIsTooSlowFor) {
  const std::vector<CameraFrame> pictures(200, Frame(kRgb, 320, 240, 0));
  RecorderOptions options{options_};
  options.queue_bytes = 0;  // Two pictures.
  Run(options, pictures);
  EXPECT_GT(status_.dropped, 100);
  EXPECT_EQ(status_.written + status_.dropped, 200);
  EXPECT_EQ(events_.CountOf(EventKind::kFrameDropped), status_.dropped);
  EXPECT_EQ(ReadSequence(options_.folder).frames.size(), static_cast<std::size_t>(status_.written));
  std::ifstream events(options_.folder / "events.jsonl");
  std::string line;
  ASSERT_TRUE(std::getline(events, line));
  const nlohmann::json event = nlohmann::json::parse(line);
  EXPECT_EQ(event["event"], "frame-dropped");
  EXPECT_EQ(event["count"], status_.dropped);
}

TEST_F(RecorderFolder, TakesAPictureAnInterval) {
  std::vector<CameraFrame> pictures;
  for (const int number : {0, 1, 29, 30, 31, 59, 62, 89, 90, 200, 201, 230}) {
    pictures.push_back(Picture(kRgb, number));
  }
  // Where the clock is stepped back, the interval goes on.
  pictures[4].time -= std::chrono::hours(1);
  RecorderOptions options{options_};
  options.interval = std::chrono::microseconds(30 * 33333);
  Run(options, pictures);
  EXPECT_THAT(offered_,
              ElementsAre(true,
                          false,
                          false,
                          true,
                          false,
                          false,
                          true,  // 60, a little late.
                          false,
                          true,
                          true,  // After a gap.
                          false,
                          true));
  EXPECT_EQ(status_.written, 6);
}

TEST_F(RecorderFolder, StopsWhereSpaceIsShort) {
  Recorder recorder(site_, Picture(kRgb, 0).buffer.layout, {options_}, events_);
  EXPECT_TRUE(recorder.Offer(Picture(kRgb, 0)));
  {
    // A PNG of noise has more.
    const FileSizeLimit limit(5000);
    recorder.Offer(Picture(kRgb, 1));
    while (recorder.Status().stopped.empty()) std::this_thread::yield();
  }
  EXPECT_FALSE(recorder.Offer(Picture(kRgb, 2)));
  recorder.Finish();
  EXPECT_EQ(events_.CountOf(EventKind::kDisk), 1);
  EXPECT_THAT(recorder.Status().stopped, HasSubstr("the recording ends: "));
  EXPECT_LE(recorder.Status().written, 1);
}

// Nothing is safe from a power cut where the disk cannot be synchronised.
TEST_F(RecorderFolder, FinishesNothingThatWasNotSynchronised) {
  RecorderOptions options{options_};
  options.sync_interval = std::chrono::hours(1);
  Recorder recorder(site_, Picture(kRgb, 0).buffer.layout, options, events_);
  recorder.Offer(Picture(kRgb, 0));
  while (recorder.Status().written == 0) std::this_thread::yield();
  recorder.Close();
  // The file of the frames, without its disk.
  const fs::path list = fs::canonical(options_.folder / "frames.jsonl");
  const int elsewhere = open("/", O_PATH);
  for (const auto& entry : fs::directory_iterator("/proc/self/fd")) {
    std::error_code error;
    if (fs::read_symlink(entry, error) == list) {
      ASSERT_GE(dup2(elsewhere, std::stoi(entry.path().filename())), 0);
    }
  }
  recorder.Finish();
  close(elsewhere);
  EXPECT_THAT(recorder.Status().stopped, HasSubstr("cannot be kept on the disk"));
  EXPECT_EQ(recorder.Status().written, 1);
  EXPECT_EQ(recorder.Status().finished, 0);
}

TEST_F(RecorderFolder, StopsBeforeTheDiskIsFull) {
  std::uint64_t free_bytes = 6'000'000;
  RecorderOptions options{options_};
  options.recording.keep_free_bytes = 5'000'000;
  // What a picture of noise takes, and a little more.
  options.recording.free_bytes = [&] { return free_bytes -= 10'000; };
  std::vector<CameraFrame> pictures;
  pictures.reserve(100);
  for (int number = 0; number < 100; ++number) pictures.push_back(Picture(kRgb, number));
  Run(options, pictures);
  EXPECT_THAT(status_.stopped, HasSubstr("expected 5 MB of free space, found 5 MB"));
  EXPECT_EQ(events_.CountOf(EventKind::kDisk), 1);
  EXPECT_GT(status_.written, 40);
  EXPECT_LT(status_.written, 100);
  pictures.resize(static_cast<std::size_t>(status_.written));
  ExpectPlays(pictures);
}

TEST_F(SequenceFolder, ChecksEntriesOfVideosAndRawPictures) {
  nlohmann::json document = Everything();
  nlohmann::json& frame = document["frames"][1];
  frame = {{"time_utc", "2005-06-21T10:30:00Z"}, {"image_ldr", "video/a.mkv"}, {"video_frame", 3}};
  EXPECT_EQ(Refusal(document), "accepted");
  frame["video_frame"] = -1;
  EXPECT_THAT(Refusal(document), HasSubstr("frames[1].video_frame: expected"));
  frame = {{"time_utc", "2005-06-21T10:30:00Z"}, {"image", "a.exr"}, {"video_frame", 3}};
  EXPECT_THAT(Refusal(document), HasSubstr("frames[1].video_frame: expected a video under"));
  const nlohmann::json raw = {{"image", "frames/a.raw"},
                              {"format", "SRGGB10P"},
                              {"stride_bytes", 10},
                              {"black_level", 64},
                              {"white_level", 1023},
                              {"white_balance_rgb", {2, 1, 1.5}}};
  frame = {{"time_utc", "2005-06-21T10:30:00Z"}, {"raw", raw}};
  EXPECT_EQ(Refusal(document), "accepted");
  const Sequence sequence = ReadSequence(folder_);
  fs::create_directories(root_ / "again");
  WriteSequence(sequence, folder_);
  EXPECT_EQ(ReadSequence(folder_).frames[1].raw->development.white_balance_rgb.z, 1.5);
  EXPECT_EQ(ReadSequence(folder_).frames[1].raw->format, sequence.frames[1].raw->format);
  frame["image_ldr"] = "frames/1.png";
  EXPECT_THAT(Refusal(document), HasSubstr("frames[1].raw: expected no `image`"));
  frame.erase("image_ldr");
  frame["raw"]["format"] = "YUYV";
  EXPECT_THAT(Refusal(document), HasSubstr("frames[1].raw.format: expected a Bayer format"));
  frame["raw"] = raw;
  frame["raw"]["image"] = "../outside.obj";
  EXPECT_THAT(Refusal(document), HasSubstr("frames[1].raw.image: expected a path inside"));
  frame["raw"] = raw;
  frame["raw"]["white_level"] = 64;
  EXPECT_THAT(Refusal(document), HasSubstr("frames[1].raw: raw development: expected 0 <= black"));
}

}  // namespace
}  // namespace pleinair::recording_test
