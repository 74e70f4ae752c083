// Sites from reconstructions and photographs: one that is made, whose truth is known, and one of
// real photographs.
#include "datasets/reconstruction/site_import.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/gtc/quaternion.hpp>

#include "calib/exif_place.h"
#include "datasets/reconstruction/internal/photograph.h"
#include "datasets/recording/site_files.h"
#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "scene/mesh_io.h"
#include "sunmodel/local_frame.h"
#include "sunmodel/time_text.h"
#include "tests/calib/reconstructed_yard.h"
#include "tests/datasets/colmap_files.h"
#include "tests/datasets/exif_picture.h"
#include "tests/datasets/made_pictures.h"
#include "tests/scene/file_size_limit.h"

namespace pleinair::site_import_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// The yard's place: coordinates of the yard about it.
const Site kPlace{RadFromDeg(48.2), RadFromDeg(-16.37), 170.0};

// Degrees, minutes and 1/10000 of seconds.
ExifValue AngleTag(int tag, double rad) {
  const std::int64_t parts = std::llround(std::abs(DegFromRad(rad)) * 36e6);
  return ExifRationals(EXIF_IFD_GPS,
                       tag,
                       {static_cast<unsigned>(parts / 36'000'000),
                        1,
                        static_cast<unsigned>(parts % 36'000'000 / 600'000),
                        1,
                        static_cast<unsigned>(parts % 600'000),
                        10'000});
}

std::vector<ExifValue> PositionTags(const Site& place) {
  return {ExifText(EXIF_IFD_GPS, EXIF_TAG_GPS_LATITUDE_REF, place.latitude_rad < 0.0 ? "S" : "N"),
          AngleTag(EXIF_TAG_GPS_LATITUDE, place.latitude_rad),
          ExifText(EXIF_IFD_GPS, EXIF_TAG_GPS_LONGITUDE_REF, place.longitude_rad < 0.0 ? "W" : "E"),
          AngleTag(EXIF_TAG_GPS_LONGITUDE, place.longitude_rad),
          ExifRationals(EXIF_IFD_GPS, EXIF_TAG_GPS_ALTITUDE, {1700, 10})};
}

struct Edits {
  bool has_positions = true;
  bool has_times = true;
  // Of the second picture's own camera, relative to the others'; 1: it is theirs.
  double second_focal_length = 1.0;
};

// A folder with the yard as COLMAP's model, turned, shrunk and moved, and its photographs.
class ImportedYard : public testing::Test {
 protected:
  void Make(const Edits& edits = {}) {
    reconstructed_yard::Options yard_options;
    yard_options.pitch_rad = RadFromDeg(18.0);
    truth_ = reconstructed_yard::MakeYard(yard_options);
    Reconstruction model = truth_;
    Transform({0.31, glm::mat3_cast(glm::normalize(glm::dquat(0.4, 0.2, -0.6, 0.5))), {3, -4, 5}},
              model);
    ColmapModel colmap;
    const CameraIntrinsics camera = reconstructed_yard::YardCamera();
    colmap.cameras.push_back({1,
                              0,
                              "SIMPLE_PINHOLE",
                              static_cast<std::uint64_t>(camera.width_px),
                              static_cast<std::uint64_t>(camera.height_px),
                              {camera.fx_px, camera.cx_px + 0.5, camera.cy_px + 0.5}});
    colmap.cameras.push_back(colmap.cameras.front());
    colmap.cameras.back().id = 2;
    colmap.cameras.back().parameters[0] *= edits.second_focal_length;
    for (const ReconstructedPoint& point : model.points) {
      colmap.points.push_back(
          {static_cast<std::uint64_t>(point.id), point.position, 150, 140, 130});
    }
    const std::vector<std::byte> jpeg = made_pictures::Jpeg(Target());
    for (std::size_t i = 0; i < model.pictures.size(); ++i) {
      const ReconstructedPicture& picture = model.pictures[i];
      ColmapImage image;
      image.id = static_cast<std::uint32_t>(i + 1);
      image.camera_from_model = glm::quat_cast(glm::dmat3(picture.camera_from_model));
      image.translation = glm::dvec3(picture.camera_from_model[3]);
      image.name = picture.name;
      if (i == 1 && edits.second_focal_length != 1.0) image.camera = 2;
      for (const PointObservation& seen : picture.observations) {
        image.seen.push_back({seen.pixel.x + 0.5,
                              seen.pixel.y + 0.5,
                              static_cast<std::uint64_t>(model.points[seen.point].id)});
      }
      colmap.images.push_back(image);
      std::vector<ExifValue> tags;
      if (edits.has_positions) tags = PositionTags(PlaceAt(truth_.pictures[i].Centre(), kPlace));
      if (edits.has_times) {
        tags.push_back(ExifText(EXIF_IFD_EXIF,
                                EXIF_TAG_DATE_TIME_ORIGINAL,
                                fmt::format("2026:06:21 12:00:{:02}", 10 * i % 60)));
        tags.push_back(ExifText(EXIF_IFD_EXIF, EXIF_TAG_OFFSET_TIME_ORIGINAL, "+02:00"));
        tags.push_back(ExifRationals(EXIF_IFD_EXIF, EXIF_TAG_EXPOSURE_TIME, {1, 500}));
        tags.push_back(ExifRationals(EXIF_IFD_EXIF, EXIF_TAG_FNUMBER, {24, 10}));
        tags.push_back(ExifShort(EXIF_IFD_EXIF, EXIF_TAG_ISO_SPEED_RATINGS, 50));
      }
      folder_.Write(picture.name, WithExif(jpeg, tags));
    }
    WriteColmapBinary(colmap, folder_);
    options_.reconstruction = folder_.Path();
    options_.photos = folder_.Path();
    options_.out = folder_ / "site";
    // From the far left of the facade's foot to the far right.
    options_.length = KnownLength{
        glm::distance(truth_.points[0].position, truth_.points[1].position), PointPair{1, 2}};
  }

  // Grey, with a bright square 400 px to the right of the middle.
  static Rgb8Image Target() {
    Rgb8Image picture(1200, 900, glm::u8vec3(120));
    for (int y = 440; y < 460; ++y) {
      for (int x = 990; x < 1010; ++x) picture.At(x, y) = glm::u8vec3(250);
    }
    return picture;
  }

  const TemporaryFolder folder_;
  Reconstruction truth_;
  SiteImportOptions options_;
};

// Within what 3 mm of GPS (the decimals of its seconds) and 2 cm of points allow.
TEST_F(ImportedYard, IsWhereItWas) {
  Make();
  const SiteImportReport report = ImportSite(options_);
  EXPECT_EQ(report.frames, truth_.pictures.size());
  EXPECT_TRUE(report.notes.empty()) << report.notes.front();
  const Sequence sequence = ReadSequence(options_.out);
  ASSERT_TRUE(sequence.site.has_value());
  // The origin is below the cameras' mean, on the ground; the yard's own coordinates are about
  // kPlace.
  const glm::dvec3 origin = EnuOf(*sequence.site, kPlace);
  glm::dvec3 mean(0.0);
  for (const ReconstructedPicture& picture : truth_.pictures) {
    mean += picture.Centre() / static_cast<double>(truth_.pictures.size());
  }
  EXPECT_LT(glm::distance(glm::dvec2(origin), glm::dvec2(mean)), 0.05);
  EXPECT_LT(DegFromRad(report.up.sigma_rad), 2.0);
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const Camera camera = sequence.CameraOfFrame(i);
    EXPECT_LT(glm::distance(camera.CentreWorldM() + glm::dvec3(glm::dvec2(origin), 0.0),
                            truth_.pictures[i].Centre()),
              0.1);
    const glm::dmat3 turned = glm::dmat3(camera.camera_from_world) *
                              glm::transpose(glm::dmat3(truth_.pictures[i].camera_from_model));
    EXPECT_LT(DegFromRad(std::acos(
                  std::min(1.0, 0.5 * (turned[0][0] + turned[1][1] + turned[2][2] - 1.0)))),
              0.3);
  }
  EXPECT_EQ(FormatUtcTime(sequence.frames[1].time), "2026-06-21T10:00:10Z");
  EXPECT_EQ(*sequence.frames[0].exposure_s, 1.0 / 500.0);
  EXPECT_EQ(*sequence.frames[0].iso, 50.0);
  EXPECT_TRUE(sequence.albedos_assumed);
  // 5 m of a receiver over the cameras' spread.
  double squares = 0.0;
  for (const ReconstructedPicture& picture : truth_.pictures) {
    squares += std::pow(glm::distance(glm::dvec2(picture.Centre()), glm::dvec2(mean)), 2.0);
  }
  EXPECT_NEAR(sequence.north_stddev_rad, 5.0 / std::sqrt(squares), 0.01);

  const LoadedMesh mesh = LoadMesh(options_.out / sequence.scene_mesh);
  EXPECT_THAT(mesh.mesh.group_names,
              testing::UnorderedElementsAre("ground", "wall-1", "wall-2", "wall-3"));
  const SiteSurface& facade = report.surfaces[1];
  EXPECT_NEAR(facade.plane.offset, -(reconstructed_yard::kFacadeY - mean.y), 0.1);

  // The folder is a site as well.
  const Sequence site = ReadSite(options_.out, UtcTime{});
  EXPECT_EQ(site.intrinsics, sequence.intrinsics);
  EXPECT_EQ(site.north_stddev_rad, sequence.north_stddev_rad);
  EXPECT_TRUE(site.camera_from_world.has_value());
  // A recording at the site copies the mesh, and not the photographs.
  const std::vector<fs::path> files = SiteFiles(options_.out, folder_ / "elsewhere");
  EXPECT_THAT(files, testing::UnorderedElementsAre("scene.mtl", "scene.obj"));
}

TEST_F(ImportedYard, ReducesPhotographsWithTheirCamera) {
  Make();
  options_.longest_side_px = 400;
  ImportSite(options_);
  const Sequence sequence = ReadSequence(options_.out);
  EXPECT_EQ(sequence.intrinsics.width_px, 400);
  EXPECT_EQ(sequence.intrinsics.height_px, 300);
  EXPECT_NEAR(sequence.intrinsics.fx_px, 800.0 / 3.0, 1e-9);
  EXPECT_NEAR(sequence.intrinsics.cx_px, 199.5, 1e-9);
  const Rgb8Image picture = ReadDisplayImage(options_.out / *sequence.frames[0].image_ldr);
  EXPECT_EQ(picture.width, 400);
  EXPECT_EQ(picture.height, 300);
}

double MiddleOfBright(const Rgb8Image& picture) {
  double sum = 0.0;
  double count = 0.0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (picture.At(x, y).g < 185) continue;
      sum += x;
      count += 1.0;
    }
  }
  return sum / count;
}

// COLMAP adjusts a camera for each picture by default: all pictures are resampled to one camera.
TEST_F(ImportedYard, PicturesOfNearlyTheSameCameraAreResampled) {
  Make({.second_focal_length = 1.02});
  EXPECT_EQ(ImportSite(options_).frames, truth_.pictures.size());
  const Sequence sequence = ReadSequence(options_.out);
  EXPECT_EQ(sequence.intrinsics.fx_px, 800.0);
  // 400 px from the middle at a focal length of 816 px are 392 px at 800.
  const auto bright = [&](std::size_t frame) {
    return MiddleOfBright(ReadDisplayImage(options_.out / *sequence.frames[frame].image_ldr));
  };
  EXPECT_NEAR(bright(0), 999.5, 0.5);
  EXPECT_NEAR(bright(1), 599.5 + 400.0 / 1.02, 0.5);
}

TEST_F(ImportedYard, PicturesOfAnotherFieldOfViewAreNoFrames) {
  Make({.second_focal_length = 1.5});
  const SiteImportReport report = ImportSite(options_);
  EXPECT_EQ(report.frames, truth_.pictures.size() - 1);
  EXPECT_THAT(report.notes, testing::Contains(HasSubstr("1 photographs of cameras")));
  options_.camera = "2";
  options_.out = folder_ / "second";
  ImportSite(options_);
  EXPECT_EQ(ReadSequence(options_.out).intrinsics.fx_px, 1200.0);
}

TEST_F(ImportedYard, ALengthIsGivenByPlacesInAPicture) {
  Make();
  const PointObservation& a = truth_.pictures[2].observations[0];
  const PointObservation& b = truth_.pictures[2].observations[50];
  const double length_m =
      glm::distance(truth_.points[a.point].position, truth_.points[b.point].position);
  options_.length = KnownLength{length_m, PickPair{"2.jpg", a.pixel + 0.5, b.pixel - 0.5}};
  EXPECT_NEAR(ImportSite(options_).metres_per_unit, 1.0 / 0.31, 1e-6);
  options_.out = folder_ / "other";
  options_.length = KnownLength{1.0, PickPair{"2.jpg", {600.0, 5.0}, b.pixel}};
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }), HasSubstr("px away"));
  options_.length = KnownLength{1.0, PickPair{"2.jpg", b.pixel, b.pixel}};
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }), HasSubstr("two points"));
  options_.length = KnownLength{1.0, PointPair{1, 99999}};
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }), HasSubstr("99999"));
}

TEST_F(ImportedYard, WithoutPositionsPlaceAndHeadingAreGiven) {
  Make({.has_positions = false});
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }), HasSubstr("--site"));
  options_.site = kPlace;
  const SiteImportReport unknown = ImportSite(options_);
  EXPECT_EQ(ReadSequence(options_.out).north_stddev_rad, RadFromDeg(180.0));
  EXPECT_FALSE(unknown.earth.has_position);
  options_.out = folder_ / "with heading";
  const double heading = RadFromDeg(12.0 - 5.0 * 3);  // As MakeYard turns its cameras.
  options_.headings = {{"3.jpg", heading, RadFromDeg(4.0)}};
  ImportSite(options_);
  const Sequence sequence = ReadSequence(options_.out);
  EXPECT_NEAR(sequence.north_stddev_rad, RadFromDeg(4.0), 1e-12);
  const glm::dvec3 forward = glm::transpose(glm::dmat3(*sequence.frames[3].camera_from_world))[2];
  EXPECT_NEAR(DegFromRad(std::atan2(forward.x, forward.y)), DegFromRad(heading), 1e-6);
  options_.length.reset();
  options_.out = folder_ / "without length";
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }), HasSubstr("--length"));
}

TEST_F(ImportedYard, TimesAreGivenWherePhotographsHaveNone) {
  Make({.has_times = false});
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }),
              HasSubstr("no time with an offset (--utc-offset, --times)"));
  // An offset of what is not there; rows of other photographs.
  options_.utc_offset = std::chrono::hours(2);
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }),
              HasSubstr("none: their EXIF data state no time (--times)"));
  options_.times = {{"04.jpg", ParseUtcTime("2026-06-21T10:00:00Z")}};
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }),
              HasSubstr("none: their EXIF data state no time, and --times does not name them"));
  options_.utc_offset.reset();
  options_.times = {{"4.jpg", ParseUtcTime("2026-06-21T10:00:00Z")},
                    {"1.jpg", ParseUtcTime("2026-06-21T11:00:00Z")}};
  const SiteImportReport report = ImportSite(options_);
  EXPECT_EQ(report.frames, 2u);
  EXPECT_THAT(report.notes, testing::ElementsAre(HasSubstr("4 photographs are no frames")));
  EXPECT_EQ(FormatUtcTime(ReadSequence(options_.out).frames[1].time), "2026-06-21T11:00:00Z");
}

TEST_F(ImportedYard, WhatIsWrongIsNamed) {
  Make();
  options_.marks = {{"none.jpg", {1.0, 2.0}, "wall"}};
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }), HasSubstr("none.jpg"));
  options_.marks.clear();
  options_.camera = "7";
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }), HasSubstr("--camera 7"));
  options_.camera.clear();
  options_.photos = folder_ / "nowhere";
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }), HasSubstr("nowhere"));
  options_.photos = folder_.Path();
  options_.out = folder_.Path();
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }), HasSubstr("empty folder"));
  options_.out = folder_ / "site";
  folder_.Write("0.jpg", ContentOf(folder_ / "1.jpg").substr(0, 300));
  EXPECT_THAT(MessageOf([&] { ImportSite(options_); }), HasSubstr("0.jpg"));
  EXPECT_FALSE(fs::exists(options_.out));
}

// What fails in writing can be run again: nothing is left, neither a site nor a part of one.
TEST_F(ImportedYard, APhotographThatCannotBeWrittenLeavesNoSite) {
  Make();
  const std::string message = [&] {
    // Mesh and sequence are smaller; the photographs are not.
    const FileSizeLimit limit(fs::file_size(folder_ / "0.jpg") - 1);
    return MessageOf([&] { ImportSite(options_); });
  }();
  EXPECT_THAT(message, HasSubstr("cannot be written: "));
  for (const auto& entry : fs::directory_iterator(folder_.Path())) {
    EXPECT_THAT(entry.path().filename().string(), testing::Not(HasSubstr("site")));
  }
  fs::create_directory(options_.out);
  EXPECT_EQ(ImportSite(options_).frames, truth_.pictures.size());
  EXPECT_TRUE(fs::exists(options_.out / "sequence.json"));
}

TEST(ExifPlace, ReadsPositionHeadingAndOrientation) {
  const TemporaryFolder folder;
  const std::vector<std::byte> jpeg = made_pictures::Jpeg(Rgb8Image(8, 8));
  std::vector<ExifValue> tags = PositionTags({RadFromDeg(-33.5), RadFromDeg(151.25), 0.0});
  tags.push_back(ExifText(EXIF_IFD_GPS, EXIF_TAG_GPS_IMG_DIRECTION_REF, "T"));
  tags.push_back(ExifRationals(EXIF_IFD_GPS, EXIF_TAG_GPS_IMG_DIRECTION, {12345, 100}));
  tags.push_back(ExifRationals(EXIF_IFD_GPS, EXIF_TAG_GPS_H_POSITIONING_ERROR, {7, 2}));
  tags.push_back(ExifText(EXIF_IFD_GPS, EXIF_TAG_GPS_DATE_STAMP, "2026:06:21"));
  tags.push_back(ExifRationals(EXIF_IFD_GPS, EXIF_TAG_GPS_TIME_STAMP, {9, 1, 8, 1, 75, 10}));
  tags.push_back(ExifShort(EXIF_IFD_0, EXIF_TAG_ORIENTATION, 6));
  const ExifPlace place = ReadExifPlace(folder.Write("a.jpg", WithExif(jpeg, tags)));
  EXPECT_NEAR(place.latitude_deg.value(), -33.5, 1e-7);
  EXPECT_NEAR(place.longitude_deg.value(), 151.25, 1e-7);
  EXPECT_EQ(place.altitude_m.value(), 170.0);
  EXPECT_EQ(place.position_sigma_m.value(), 3.5);
  EXPECT_EQ(place.heading_deg.value(), 123.45);
  EXPECT_EQ(place.utc, "2026-06-21T09:08:07.500Z");
  EXPECT_EQ(place.orientation, 6);
  const ExifPlace none = ReadExifPlace(folder.Write("b.jpg", WithExif(jpeg, ExifTags())));
  EXPECT_FALSE(none.latitude_deg || none.longitude_deg || none.heading_deg);
  EXPECT_FALSE(none.orientation);
  EXPECT_EQ(none.utc, "");
  EXPECT_FALSE(ReadExifPlace(folder / "absent.jpg").latitude_deg.has_value());
}

TEST(ExifPlaceHardCases, ImpossibleValuesAreNone) {
  const TemporaryFolder folder;
  const std::vector<std::byte> jpeg = made_pictures::Jpeg(Rgb8Image(8, 8));
  std::vector<ExifValue> tags = PositionTags(kPlace);
  tags[1] = ExifRationals(EXIF_IFD_GPS, EXIF_TAG_GPS_LATITUDE, {91, 1, 0, 1, 0, 1});
  tags.push_back(ExifText(EXIF_IFD_GPS, EXIF_TAG_GPS_IMG_DIRECTION_REF, "M"));
  tags.push_back(ExifRationals(EXIF_IFD_GPS, EXIF_TAG_GPS_IMG_DIRECTION, {90, 1}));
  tags.push_back(ExifText(EXIF_IFD_GPS, EXIF_TAG_GPS_DATE_STAMP, "2026-06-21"));
  tags.push_back(ExifRationals(EXIF_IFD_GPS, EXIF_TAG_GPS_TIME_STAMP, {9, 1, 8, 1, 7, 1}));
  tags.push_back(ExifShort(EXIF_IFD_0, EXIF_TAG_ORIENTATION, 9));
  const ExifPlace place = ReadExifPlace(folder.Write("a.jpg", WithExif(jpeg, tags)));
  EXPECT_FALSE(place.latitude_deg.has_value());
  EXPECT_FALSE(place.heading_deg.has_value());  // From magnetic north.
  EXPECT_EQ(place.utc, "");
  EXPECT_FALSE(place.orientation);
  tags[1] = ExifRationals(EXIF_IFD_GPS, EXIF_TAG_GPS_LATITUDE, {48, 0, 0, 1, 0, 1});
  EXPECT_FALSE(ReadExifPlace(folder.Write("b.jpg", WithExif(jpeg, tags))).latitude_deg);
}

// EXIF times are local: what gives them a zone.
TEST(Photograph, FindsItsTimeZone) {
  const TemporaryFolder folder;
  const std::vector<std::byte> jpeg = made_pictures::Jpeg(Rgb8Image(8, 8));
  const auto time_of = [&](const std::vector<ExifValue>& tags,
                           const std::string& utc,
                           std::optional<std::chrono::minutes> offset) -> std::string {
    const fs::path file = folder.Write("a.jpg", WithExif(jpeg, tags));
    ExifPlace place;
    place.utc = utc;
    const auto time = TimeOf(file, place, offset);
    return time ? FormatUtcTime(*time) : "none";
  };
  const ExifValue local =
      ExifText(EXIF_IFD_EXIF, EXIF_TAG_DATE_TIME_ORIGINAL, "2026:06:21 11:50:04");
  const ExifValue zone = ExifText(EXIF_IFD_EXIF, EXIF_TAG_OFFSET_TIME_ORIGINAL, "+05:45");
  constexpr std::chrono::minutes kTwoHours{120};
  EXPECT_EQ(time_of({local}, "", std::nullopt), "none");
  EXPECT_EQ(time_of({local}, "", kTwoHours), "2026-06-21T09:50:04Z");
  EXPECT_EQ(time_of({local, zone}, "", kTwoHours), "2026-06-21T06:05:04Z");
  // The receiver's clock is 50 s behind: two hours ahead of UTC.
  EXPECT_EQ(time_of({local}, "2026-06-21T09:49:14Z", std::nullopt), "2026-06-21T09:50:04Z");
  // No zone is 67 minutes ahead: the camera's clock is wrong.
  EXPECT_EQ(time_of({local}, "2026-06-21T10:43:00Z", std::nullopt), "2026-06-21T10:43:00Z");
  EXPECT_EQ(time_of({}, "2026-06-21T10:43:00Z", kTwoHours), "2026-06-21T10:43:00Z");
}

// Planes of the mesh that a person made of the same photographs, in its own world (its README).
constexpr double kBackWallM = -21.087;
constexpr double kFrontWallM = -9.983;
const glm::dvec3 kFacadeNormal = glm::normalize(glm::dvec3(-0.85355, -0.52101, 0.0));

// The rotation and translation that take cameras to those of the sequence.
Similarity FromCameras(const Sequence& made, const Sequence& reference) {
  glm::dmat3 sum(0.0);
  glm::dvec3 made_mean(0.0);
  glm::dvec3 reference_mean(0.0);
  const auto count = static_cast<double>(made.frames.size());
  for (std::size_t i = 0; i < made.frames.size(); ++i) {
    const Camera a = made.CameraOfFrame(i);
    const Camera b = reference.CameraOfFrame(i);
    sum += glm::transpose(glm::dmat3(b.camera_from_world)) * glm::dmat3(a.camera_from_world);
    made_mean += a.CentreWorldM() / count;
    reference_mean += b.CentreWorldM() / count;
  }
  // The nearest rotation, by the iteration of its polar decomposition.
  for (int i = 0; i < 20; ++i) sum = 0.5 * (sum + glm::transpose(glm::inverse(sum)));
  return {1.0, sum, reference_mean - sum * made_mean};
}

// COLMAP's model of three photographs of a facade against the mesh that a person made of them:
// ground, back wall and front wall within 1 % of their size and 1 degree.
TEST(RecordedSiteImport, AFacadeIsWhereAPersonHasIt) {
  const fs::path recording = fs::path(PLEINAIR_SHARED_DIR) / "sequences" / "berlin-photos";
  if (!fs::exists(recording)) GTEST_SKIP() << recording << " is absent";
  const TemporaryFolder folder;
  const Sequence reference = ReadSequence(recording);
  SiteImportOptions options;
  options.reconstruction = PLEINAIR_SOURCE_DIR "/tests/datasets/berlin_colmap";
  options.photos = recording / "frames_ldr";
  options.out = folder / "site";
  options.site = reference.site;
  options.headings = {{"000001.jpg", RadFromDeg(60.5), RadFromDeg(10.0)}};  // Its compass.
  // From one end of the facade to the other; by the reference's cameras.
  options.length = KnownLength{27.766, PointPair{964, 1303}};
  for (std::size_t i = 0; i < reference.frames.size(); ++i) {
    options.times[fmt::format("{:06}.jpg", i)] = reference.frames[i].time;
  }
  const SiteImportReport report = ImportSite(options);
  const Sequence made = ReadSequence(options.out);
  // The ground is assumed: nothing is sampled there.
  EXPECT_THAT(made.diffuse_regions, testing::Not(testing::Contains("ground")));
  EXPECT_THAT(made.diffuse_regions, testing::Contains("wall-1"));
  const Similarity move = FromCameras(made, reference);
  const auto moved = [&](const Plane& plane) {
    const glm::dvec3 normal = move.rotation * plane.normal;
    return Plane{normal, plane.offset + glm::dot(normal, move.translation)};
  };
  const auto angle_deg = [](const glm::dvec3& a, const glm::dvec3& b) {
    return DegFromRad(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
  };
  const Plane ground = moved(report.surfaces[0].plane);
  EXPECT_LT(angle_deg(ground.normal, {0.0, 0.0, 1.0}), 1.0);
  // The facade is 40 m long; no points show the ground, whose height is the photographer's.
  EXPECT_LT(std::abs(ground.offset), 0.4);

  struct Wall {
    double offset_m;
    double size_m;  // Of the reference's rectangle, across.
  };
  std::vector<double> front_offsets_m;
  for (const Wall& wall : {Wall{kBackWallM, 22.8}, Wall{kFrontWallM, 25.6}}) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const SiteSurface& surface : report.surfaces) {
      if (angle_deg(moved(surface.plane).normal, kFacadeNormal) > 1.0) continue;
      glm::dvec3 middle(0.0);
      double corners = 0.0;
      for (const auto& polygon : surface.polygons) {
        for (const glm::dvec3& p : polygon) {
          middle += move.rotation * p + move.translation;
          corners += 1.0;
        }
      }
      const double off_m = std::abs(glm::dot(kFacadeNormal, middle / corners) - wall.offset_m);
      nearest_m = std::min(nearest_m, off_m);
      if (wall.offset_m == kFrontWallM && off_m < 1.0) {
        EXPECT_LT(off_m, 0.01 * wall.size_m) << surface.name;
        front_offsets_m.push_back(surface.plane.offset);
      }
    }
    EXPECT_LT(nearest_m, 0.01 * wall.size_m);
  }
  // It is one plane on both sides of the portal.
  ASSERT_EQ(front_offsets_m.size(), 2u);
  EXPECT_NEAR(front_offsets_m[0], front_offsets_m[1], 1e-9);
}

}  // namespace
}  // namespace pleinair::site_import_test
