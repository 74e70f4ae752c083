#include "datasets/picture_source.h"

#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "calib/exif_time.h"
#include "datasets/posed_frame_source.h"
#include "datasets/stated_pose.h"
#include "datasets/video/video_writer.h"
#include "scene/image_io.h"
#include "sunmodel/time_text.h"
#include "tests/datasets/exif_picture.h"
#include "tests/datasets/made_pictures.h"
#include "tests/datasets/sequence_fixture.h"

namespace pleinair::picture_source_test {
namespace {

namespace fs = std::filesystem;
using made_pictures::Noise;
using Tags = ExifTags;
using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr int kWidth = 64;
constexpr int kHeight = 48;

class PictureFolder : public SequenceFolder {
 protected:
  void SetUp() override {
    SequenceFolder::SetUp();
    WriteDocument(Everything());
    site_ = ReadSite(folder_, UtcTime{});
    pictures_ = root_ / "pictures";
    fs::create_directories(pictures_);
  }

  void AddPicture(const std::string& name, const Tags& tags, unsigned seed = 0) {
    Write(pictures_ / name, WithExif(made_pictures::Jpeg(Noise(kWidth, kHeight, seed)), tags));
  }
  std::string RefusalOf(const PictureTimes& times) const {
    std::string reasons[2];
    const std::function<void()> steps[] = {[&] { MakeFrameSourceAt(site_, pictures_, times); },
                                           [&] { FirstPictureTime(pictures_, times); }};
    for (int i = 0; i < 2; ++i) {
      reasons[i] = "accepted";
      try {
        steps[i]();
      } catch (const std::exception& error) {
        reasons[i] = error.what();
      }
    }
    EXPECT_EQ(reasons[0], reasons[1]);
    return reasons[0];
  }

  static std::vector<std::string> TimesOf(FrameSource& source) {
    std::vector<std::string> times;
    while (const auto frame = source.Next()) {
      times.push_back(*frame ? FormatUtcTime((*frame)->time) : frame->error().reason);
    }
    return times;
  }

  Sequence site_;
  fs::path pictures_;
};

TEST_F(PictureFolder, GoesToAnyPicture) {
  AddPicture("a.jpg", {"2026:06:21 11:50:01", "", "Z", false}, 1);
  AddPicture("b.jpg", {"2026:06:21 11:50:02", "", "Z", false}, 2);
  AddPicture("c.jpg", {"2026:06:21 11:50:03", "", "Z", false}, 3);
  const auto source = MakeFrameSourceAt(site_, pictures_, {});
  ASSERT_TRUE(source->Seek(2));
  EXPECT_EQ((*source->Next())->index, 2);
  EXPECT_FALSE(source->Next());
  ASSERT_TRUE(source->Seek(1));
  EXPECT_EQ(TimesOf(*source),
            (std::vector<std::string>{"2026-06-21T11:50:02Z", "2026-06-21T11:50:03Z"}));
}

TEST_F(PictureFolder, TakesAPictureByItself) {
  AddPicture("a.jpg", {"2026:06:21 11:50:01", "", "Z", false}, 1);
  AddPicture("b.jpg", {"2026:06:21 11:50:02", "", "Z", false}, 2);
  const fs::path picture = pictures_ / "b.jpg";
  EXPECT_TRUE(IsPictureOrFolder(picture));
  EXPECT_EQ(FormatUtcTime(FirstPictureTime(picture, {})), "2026-06-21T11:50:02Z");
  const auto source = MakeFrameSourceAt(site_, picture, {});
  EXPECT_EQ(source->Count(), 1);
  EXPECT_EQ(TimesOf(*source), std::vector<std::string>{"2026-06-21T11:50:02Z"});
  Write(pictures_ / "notes.txt", "taken at noon");
  EXPECT_FALSE(IsPictureOrFolder(pictures_ / "notes.txt"));
}

// Such a picture shows another view than the site's pose.
TEST_F(PictureFolder, RefusesPicturesOfACameraHeldOtherwise) {
  for (unsigned orientation = 0; orientation <= 8; ++orientation) {
    const std::string time = "2026:06:21 11:50:0" + std::to_string(orientation);
    AddPicture(std::to_string(orientation) + ".jpg", {time, "", "Z", false, orientation});
  }
  const auto source = MakeFrameSourceAt(site_, pictures_, {});
  for (unsigned orientation = 0; orientation <= 8; ++orientation) {
    const auto frame = source->Next();
    EXPECT_EQ(frame->has_value(), orientation <= 2) << orientation;
    if (*frame) continue;
    EXPECT_THAT(frame->error().reason,
                HasSubstr("found EXIF orientation " + std::to_string(orientation) + ": a pose"));
  }
  // A pose for a camera held so takes it.
  for (unsigned orientation = 1; orientation <= 8; ++orientation) {
    const fs::path picture = pictures_ / (std::to_string(orientation) + ".jpg");
    Sequence held = site_;
    held.camera_from_world = PoseLookingAt({0.0, 0.0, 1.6}, {0.0, 10.0, 1.0}, UpInPicture(picture));
    EXPECT_GT(glm::determinant(glm::dmat3(*held.camera_from_world)), 0.999);
    EXPECT_TRUE(MakeFrameSourceAt(held, picture, {})->Next()->has_value()) << orientation;
  }
  // One that moves may be held in any way.
  const auto moving = MakeFrameSourceAt(WithoutPoses(site_), pictures_, {});
  while (const auto frame = moving->Next()) EXPECT_TRUE(frame->has_value());
}

TEST_F(PictureFolder, TakesTimesAndExposureFromExif) {
  AddPicture("b.jpg", {"2026:06:21 11:50:00", "25", "+02:00", true}, 1);
  AddPicture("a.jpg", {"2026:06:21 11:50:01", "", "+02:00", false}, 2);
  AddPicture("c.jpg", {"2026:06:21 09:49:59", "5", "", false}, 3);
  Write(pictures_ / "notes.txt", "taken at noon");
  Write(pictures_ / ".hidden.jpg", "x");
  Write(pictures_ / "empty.jpg", "");
  PictureTimes times;
  times.utc_offset = "Z";
  const auto source = MakeFrameSourceAt(site_, pictures_, times);
  EXPECT_EQ(source->Count(), 3);
  EXPECT_EQ(FormatUtcTime(FirstPictureTime(pictures_, times)), "2026-06-21T09:49:59.5Z");
  const auto first = source->Next();
  EXPECT_EQ(FormatUtcTime((*first)->time), "2026-06-21T09:49:59.5Z");
  EXPECT_EQ((*first)->units, LightUnits::kRelativePerFrame);
  EXPECT_EQ((*first)->camera.intrinsics.width_px, kWidth);
  const auto second = source->Next();
  EXPECT_EQ((*second)->index, 1);
  EXPECT_EQ(FormatUtcTime((*second)->time), "2026-06-21T09:50:00.25Z");
  EXPECT_EQ((*second)->units, LightUnits::kRelative);
  EXPECT_NEAR((*second)->exposure.value(), 200.0 / 250.0 / (2.8 * 2.8), 1e-12);
  const std::vector<std::byte> jpeg = made_pictures::Jpeg(Noise(kWidth, kHeight, 1));
  PictureLayout layout{{PixelCoding::kMjpeg}, kWidth, kHeight, 0, {}};
  EXPECT_EQ((*second)->codes->pixels, DecodeCodes(jpeg, layout)->pixels);
  EXPECT_EQ(TimesOf(*source), std::vector<std::string>{"2026-06-21T09:50:01Z"});
}

TEST_F(PictureFolder, TakesTimesFromTheCaller) {
  AddPicture("2.jpg", {"2026:06:21 11:50:00", "", "+02:00", false});
  WritePng(pictures_ / "1.png", Noise(kWidth, kHeight, 4));
  PictureTimes times;
  times.start = ParseUtcTime("2026-01-01T12:00:00Z");
  times.interval = milliseconds(2500);
  EXPECT_EQ(TimesOf(*MakeFrameSourceAt(site_, pictures_, times)),
            (std::vector<std::string>{"2026-01-01T12:00:00Z", "2026-01-01T12:00:02.5Z"}));
}

TEST_F(PictureFolder, ReportsABadPictureInItsPlace) {
  AddPicture("a.jpg", {"2026:06:21 11:50:00", "", "Z", false});
  WritePng(pictures_ / "b.png", Noise(kWidth, kHeight, 4));  // Without a time.
  AddPicture("c.jpg", {"2026:06:21 11:50:02", "", "Z", false});
  fs::resize_file(pictures_ / "c.jpg", fs::file_size(pictures_ / "c.jpg") / 2);
  AddPicture("d.jpg", {"2026:06:31 11:50:02", "", "Z", false});  // No such day.
  Write(
      pictures_ / "e.jpg",
      WithExif(made_pictures::Jpeg(Noise(40, 40, 0)), Tags{"2026:06:21 11:50:04", "", "Z", false}));
  AddPicture("f.jpg", {"2026:06:21 11:50:05", "", "Z", false});
  const std::vector<std::string> times = TimesOf(*MakeFrameSourceAt(site_, pictures_, {}));
  ASSERT_EQ(times.size(), 6u);
  EXPECT_EQ(times[0], "2026-06-21T11:50:00Z");
  EXPECT_THAT(times[1], HasSubstr("b.png: expected an EXIF time, found none"));
  EXPECT_THAT(times[2], HasSubstr("c.jpg: "));
  EXPECT_THAT(times[3], HasSubstr("d.jpg: EXIF time '2026-06-31T11:50:02Z': "));
  EXPECT_THAT(times[4], HasSubstr("e.jpg: camera picture: expected the shape of the site's"));
  EXPECT_EQ(times[5], "2026-06-21T11:50:05Z");
}

TEST_F(PictureFolder, RefusesPicturesWithoutTimes) {
  EXPECT_THAT(RefusalOf({}), HasSubstr("pictures: expected PNG or JPEG pictures, found none"));
  WritePng(pictures_ / "1.png", Noise(kWidth, kHeight, 4));
  EXPECT_THAT(RefusalOf({}), HasSubstr("1.png: expected an EXIF time, found none"));
  fs::remove(pictures_ / "1.png");
  AddPicture("1.jpg", {"2026:06:21 11:50:00", "", "", false});
  EXPECT_THAT(RefusalOf({}), HasSubstr("1.jpg: expected a time zone in EXIF, found none"));
  AddPicture("2.jpg", {"2026:06:21 11:50:00", "", "", false});
  PictureTimes times;
  times.utc_offset = "CEST";
  EXPECT_THAT(RefusalOf(times), HasSubstr("time zone 'CEST': expected Z, or such as +02:00"));
  times = {};
  times.interval = milliseconds(1);
  EXPECT_THAT(RefusalOf(times), HasSubstr("expected --start-time with --every"));
  times = {};
  times.start = UtcTime{};
  EXPECT_THAT(RefusalOf(times), HasSubstr("expected --every with --start-time"));
  pictures_ = root_ / "nowhere";
  EXPECT_THAT(RefusalOf({}), HasSubstr("nowhere: no such file"));
}

TEST_F(PictureFolder, PlaysAVideoAtItsTimes) {
  pictures_ = root_ / "walk.mkv";
  const UtcTime start = ParseUtcTime("2026-06-21T09:50:00.25Z");
  {
    VideoWriter writer(pictures_, {VideoCodec::kFfv1, kWidth, kHeight, false, start});
    for (unsigned i = 0; i < 3; ++i) writer.Add(Noise(kWidth, kHeight, i), i * milliseconds(40));
  }
  EXPECT_EQ(FirstPictureTime(pictures_, {}), start);
  const auto source = MakeFrameSourceAt(site_, pictures_, {});
  for (unsigned i = 0; i < 3; ++i) {
    const auto frame = source->Next();
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((*frame)->index, static_cast<int>(i));
    EXPECT_EQ((*frame)->time, start + i * milliseconds(40));
    EXPECT_EQ((*frame)->units, LightUnits::kRelativePerFrame);
    EXPECT_EQ((*frame)->codes->pixels, Noise(kWidth, kHeight, i).pixels);
  }
  EXPECT_FALSE(source->Next());
  ASSERT_TRUE(source->Seek(1));
  const auto again = source->Next();
  ASSERT_TRUE(again && *again);
  EXPECT_EQ((*again)->index, 1);
  EXPECT_EQ((*again)->codes->pixels, Noise(kWidth, kHeight, 1).pixels);
  PictureTimes times;
  times.start = ParseUtcTime("2025-01-01T00:00:00Z");
  EXPECT_EQ(TimesOf(*MakeFrameSourceAt(site_, pictures_, times)).back(), "2025-01-01T00:00:00.08Z");
}

TEST_F(PictureFolder, RefusesAVideoWithoutATime) {
  pictures_ = root_ / "walk.mkv";
  VideoWriter(pictures_, {VideoCodec::kFfv1, kWidth, kHeight, false, {}})
      .Add(Noise(kWidth, kHeight, 0), {});
  EXPECT_THAT(RefusalOf({}), HasSubstr("expected a creation time in the video, found none"));
}

TEST_F(PictureFolder, KeepsExifTimesAsTheyStand) {
  AddPicture("a.jpg", {"2026:06:21 11:50:00", "123456789123", "-03:30", false});
  const std::optional<ExifTime> time = ReadExifTime(pictures_ / "a.jpg");
  ASSERT_TRUE(time);
  EXPECT_EQ(time->local_time, "2026-06-21T11:50:00.123456789");
  EXPECT_EQ(time->utc_offset, "-03:30");
  AddPicture("b.jpg", {"    :  :     :  :  ", "", "", false});
  EXPECT_FALSE(ReadExifTime(pictures_ / "b.jpg"));
  EXPECT_FALSE(ReadExifTime(pictures_ / "absent.jpg"));
  EXPECT_FALSE(ReadExifTime(folder_ / "fisheye.json"));
}

}  // namespace
}  // namespace pleinair::picture_source_test
