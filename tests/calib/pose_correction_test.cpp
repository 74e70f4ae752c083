#include "calib/pose_correction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "sunmodel/angles.h"
#include "tests/calib/marker_scene.h"
#include "tests/calib/village_scene.h"

namespace pleinair::pose_correction_test {
namespace {

using testing::HasSubstr;

// Between the houses, where an object would stand.
constexpr glm::dvec3 kPlaceM(0.2, 4.5, 0.5);

// The house's shadow on the lawn and over a wall: another one at each time of the day.
Rgb8Image WithShadow(Rgb8Image picture, int time) {
  cv::Mat view(picture.height, picture.width, CV_8UC3, picture.pixels.data());
  cv::Mat shadow(view.size(), CV_32FC3, cv::Scalar(1.0, 1.0, 1.0));
  const int x = 65 + 45 * time;
  const std::vector<cv::Point> outline{{x, 95}, {x + 55, 85}, {x + 100, 210}, {x + 5, 220}};
  cv::fillPoly(shadow, std::vector<std::vector<cv::Point>>{outline}, cv::Scalar(0.5, 0.5, 0.6));
  cv::multiply(view, shadow, view, 1.0, CV_8UC3);
  return picture;
}

// The village with corners that are elsewhere; the lawn stays.
Mesh Displaced(Mesh mesh, double sigma_m, unsigned seed) {
  constexpr std::size_t kCornersOfTheLawn = 8;
  std::mt19937 random(seed);
  std::normal_distribution<float> normal(0.0f, static_cast<float>(sigma_m));
  for (std::size_t i = kCornersOfTheLawn; i < mesh.positions_m.size(); ++i) {
    for (int c = 0; c < 3; ++c) mesh.positions_m[i][c] += normal(random);
  }
  return mesh;
}

class PoseCorrectionTest : public testing::Test {
 protected:
  PoseCorrection Correct(std::span<const Rgb8Image> pictures, const glm::dmat4& stated) const {
    return CorrectPoseByEdges(lens_, pictures, {EdgesOf(mesh_, rays_), rays_}, stated);
  }

  // By how far the place is elsewhere in the picture than from the true pose.
  double OffPx(const glm::dmat4& pose) const {
    const auto pixel = [&](const glm::dmat4& from) {
      return *lens_.ProjectToPixel(glm::dvec3(from * glm::dvec4(kPlaceM, 1.0)));
    };
    return glm::distance(pixel(pose), pixel(kVillagePose));
  }

  const Mesh mesh_ = Village();
  const RayCaster rays_{mesh_};
  const Lens lens_{HalfSize(MarkerCamera())};
  const FineCamera camera_{lens_};
};

// Poses that are off as PoseCorrectionOptions expects, and a mesh that is off by 2 cm: pictures at
// three times of the day put an object where it belongs to less than a third of what the stated
// poses do.
TEST_F(PoseCorrectionTest, PutsObjectsWhereTheyBelong) {
  const PoseCorrectionOptions expected;
  constexpr unsigned kDraws = 8;
  double stated_squares = 0.0;
  double corrected_squares = 0.0;
  double sigma_squares = 0.0;
  for (unsigned seed = 0; seed < kDraws; ++seed) {
    const Mesh real = Displaced(mesh_, 0.012, seed);
    std::vector<Rgb8Image> pictures;
    pictures.reserve(3);
    for (int time = 0; time < 3; ++time) {
      pictures.push_back(WithShadow(PictureOf(real, camera_, kVillagePose, 3 * seed), time));
    }
    const double factor = std::sqrt(3.0);  // Three axes.
    const glm::dmat4 stated = Moved(kVillagePose,
                                    factor * expected.rotation_sigma_rad,
                                    factor * expected.position_sigma_m,
                                    seed);
    const PoseCorrection found = Correct(pictures, stated);
    EXPECT_TRUE(found.corrected || OffPx(stated) < 1.5) << seed;
    stated_squares += std::pow(OffPx(stated), 2);
    corrected_squares += std::pow(OffPx(found.camera_from_world), 2);
    sigma_squares += std::pow(*PlaceSigmaPx(lens_, found, kPlaceM), 2);
  }
  const double stated_px = std::sqrt(stated_squares / kDraws);
  const double corrected_px = std::sqrt(corrected_squares / kDraws);
  EXPECT_GT(stated_px, 1.5) << "the draws are of the size that is meant";
  EXPECT_LT(corrected_px, stated_px / 3.0);
  // The stated deviation of the place is of the size of the error, and no smaller than half of it.
  const double sigma_px = std::sqrt(sigma_squares / kDraws);
  EXPECT_LT(corrected_px, 2.0 * sigma_px);
  EXPECT_LT(sigma_px, stated_px / 2.0);
}

// A careful site: poses that are off by a fifth of what is expected, or half a pixel, and a mesh
// that is off by some millimetres.
TEST_F(PoseCorrectionTest, SeesPosesThatAreOffByFractionsOfAPixel) {
  const PoseCorrectionOptions expected;
  constexpr unsigned kDraws = 8;
  double stated_squares = 0.0;
  double corrected_squares = 0.0;
  for (unsigned seed = 0; seed < kDraws; ++seed) {
    const Mesh real = Displaced(mesh_, 0.003, seed);
    const Rgb8Image picture = PictureOf(real, camera_, kVillagePose, 3 * seed);
    const double factor = 0.2 * std::sqrt(3.0);  // Three axes.
    const glm::dmat4 stated = Moved(kVillagePose,
                                    factor * expected.rotation_sigma_rad,
                                    factor * expected.position_sigma_m,
                                    seed);
    stated_squares += std::pow(OffPx(stated), 2);
    corrected_squares += std::pow(OffPx(Correct({&picture, 1}, stated).camera_from_world), 2);
  }
  const double stated_px = std::sqrt(stated_squares / kDraws);
  EXPECT_LT(stated_px, 1.0) << "the draws are of the size that is meant";
  EXPECT_LT(std::sqrt(corrected_squares / kDraws), 0.6 * stated_px);
}

// A house that is drawn 10 cm too high, or 3 px: the other edges agree on the pose.
TEST_F(PoseCorrectionTest, WrongRoofDoesNotTiltTheCamera) {
  Mesh real = mesh_;
  for (glm::vec3& corner : real.positions_m) corner.z -= corner.z == 5.0f ? 0.1f : 0.0f;
  for (unsigned seed = 0; seed < 3; ++seed) {
    const Rgb8Image picture = PictureOf(real, camera_, kVillagePose, seed);
    EXPECT_LT(OffPx(Correct({&picture, 1}, kVillagePose).camera_from_world), 0.5) << seed;
    const glm::dmat4 stated = Moved(kVillagePose, RadFromDeg(0.5), 0.05, seed);
    EXPECT_LT(OffPx(Correct({&picture, 1}, stated).camera_from_world), 1.0) << seed;
  }
}

// On the axis a rotation about the camera moves a point by focal length times angle, a translation
// by focal length over depth.
TEST_F(PoseCorrectionTest, PlaceSigmaIsThatOfRotationAndTranslation) {
  constexpr double kTurnRad = 0.004;
  constexpr double kMoveM = 0.05;
  constexpr double kDepthM = 7.0;
  CameraIntrinsics undistorted;
  undistorted.width_px = 640;
  undistorted.height_px = 480;
  undistorted.fx_px = undistorted.fy_px = 500.0;
  undistorted.cx_px = 319.5;
  undistorted.cy_px = 239.5;
  const Lens lens(undistorted);
  PoseCorrection found;
  found.camera_from_world = kVillagePose;
  for (std::size_t i = 0; i < 6; ++i) {
    found.motion_covariance[i][i] = std::pow(i < 3 ? kTurnRad : kMoveM, 2);
  }
  const auto world = [&](double depth_m, double right_m = 0.0) {
    return glm::dvec3(glm::inverse(kVillagePose) * glm::dvec4(right_m, 0.0, depth_m, 1.0));
  };
  const double along_axis_px = 500.0 * std::hypot(kTurnRad, kMoveM / kDepthM);
  EXPECT_NEAR(*PlaceSigmaPx(lens, found, world(kDepthM)), std::sqrt(2.0) * along_axis_px, 1e-9);
  EXPECT_FALSE(PlaceSigmaPx(lens, found, world(-kDepthM)));
  EXPECT_FALSE(PlaceSigmaPx(lens, found, world(kDepthM, kDepthM))) << "beside the picture";
}

// Nothing is found of a pose that stays for lack of edges: its deviation is the expected one.
TEST_F(PoseCorrectionTest, WithoutEdgesTheDeviationIsTheExpectedOne) {
  const PoseCorrectionOptions expected;
  const RayCaster nothing{Mesh{}};
  const Rgb8Image picture = PictureOf(mesh_, camera_, kVillagePose, 0);
  const PoseCorrection found =
      CorrectPoseByEdges(lens_, {&picture, 1}, {{}, nothing}, kVillagePose);
  EXPECT_FALSE(found.corrected);
  for (std::size_t i = 0; i < 6; ++i) {
    const double sigma = i < 3 ? expected.rotation_sigma_rad : expected.position_sigma_m;
    EXPECT_DOUBLE_EQ(found.motion_covariance[i][i], sigma * sigma);
  }
}

// Shadows, people and noise do not move a pose that is right.
TEST_F(PoseCorrectionTest, KeepsAPoseThatAgrees) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Rgb8Image picture = PictureOf(mesh_, camera_, kVillagePose, seed);
    for (const Rgb8Image& seen : {picture, WithShadow(picture, static_cast<int>(seed))}) {
      const PoseCorrection found = Correct({&seen, 1}, kVillagePose);
      EXPECT_FALSE(found.corrected) << seed;
      EXPECT_THAT(found.reason, HasSubstr("agree with it"));
      EXPECT_EQ(found.camera_from_world, kVillagePose);
    }
  }
}

// Nor does a mesh that is off, by more than what it is off itself: 2 cm are 0.6 px here.
TEST_F(PoseCorrectionTest, MeshThatIsOffMovesItLittle) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Rgb8Image picture = PictureOf(Displaced(mesh_, 0.012, seed), camera_, kVillagePose, seed);
    EXPECT_LT(OffPx(Correct({&picture, 1}, kVillagePose).camera_from_world), 0.6) << seed;
  }
}

// A mesh that was drawn by hand: its edges are 3 px off here, each its own way, and say little of
// the camera, by far less than they are off themselves.
TEST_F(PoseCorrectionTest, MeshThatIsFarOffMovesItLittle) {
  double squares = 0.0;
  constexpr unsigned kDraws = 6;
  for (unsigned seed = 0; seed < kDraws; ++seed) {
    const Rgb8Image picture = PictureOf(Displaced(mesh_, 0.1, seed), camera_, kVillagePose, seed);
    squares += std::pow(OffPx(Correct({&picture, 1}, kVillagePose).camera_from_world), 2);
  }
  EXPECT_LT(std::sqrt(squares / kDraws), 1.0);
}

// Cut into many pieces, an edge is still one: neither pose nor odds follow from how a mesh is cut.
TEST_F(PoseCorrectionTest, HowFinelyAMeshIsCutChangesNothing) {
  const Rgb8Image picture = PictureOf(mesh_, camera_, kVillagePose, 1);
  const glm::dmat4 stated = Moved(kVillagePose, RadFromDeg(0.5), 0.05, 2);
  const std::vector<MeshEdge> edges = EdgesOf(mesh_, rays_);
  std::vector<MeshEdge> cut;
  constexpr int kPieces = 8;
  for (const MeshEdge& edge : edges) {
    std::array<glm::dvec3, kPieces + 1> ends;
    for (int i = 0; i <= kPieces; ++i) {
      ends[static_cast<std::size_t>(i)] =
          glm::mix(edge.from_m, edge.to_m, static_cast<double>(i) / kPieces);
    }
    for (std::size_t i = 0; i < kPieces; ++i) {
      MeshEdge piece = edge;
      piece.from_m = ends[i];
      piece.to_m = ends[i + 1];
      if (i % 3 == 1) std::swap(piece.from_m, piece.to_m);
      cut.push_back(piece);
    }
  }
  std::shuffle(cut.begin(), cut.end(), std::mt19937(1));
  EXPECT_EQ(JoinedEdges(cut).size(), edges.size());
  const PoseCorrection as_is = CorrectPoseByEdges(lens_, {&picture, 1}, {edges, rays_}, stated);
  const PoseCorrection of_cut = CorrectPoseByEdges(lens_, {&picture, 1}, {cut, rays_}, stated);
  ASSERT_TRUE(as_is.corrected);
  ASSERT_TRUE(of_cut.corrected);
  // Places lie elsewhere on the edges, up to half a step of 8 px.
  EXPECT_LT(std::abs(OffPx(of_cut.camera_from_world) - OffPx(as_is.camera_from_world)), 0.3);
  EXPECT_NEAR(of_cut.shift_sigma_px / as_is.shift_sigma_px, 1.0, 0.15);
  EXPECT_NEAR(of_cut.log_odds / as_is.log_odds, 1.0, 0.3);
}

// Pictures of the night, or of fog, do not outvote the one that shows edges.
TEST_F(PoseCorrectionTest, PicturesWithoutEdgesDoNotCount) {
  const glm::dmat4 stated = Moved(kVillagePose, RadFromDeg(0.5), 0.05, 2);
  std::vector<Rgb8Image> pictures{PictureOf(mesh_, camera_, kVillagePose, 1)};
  const PoseCorrection of_one = Correct(pictures, stated);
  ASSERT_TRUE(of_one.corrected);
  for (int night = 0; night < 4; ++night) pictures.emplace_back(320, 240, glm::u8vec3(3));
  const PoseCorrection of_five = Correct(pictures, stated);
  EXPECT_TRUE(of_five.corrected);
  EXPECT_EQ(of_five.camera_from_world, of_one.camera_from_world);
}

// A pose that is as wrong as none should be stays as it is, or moves by some pixels.
TEST_F(PoseCorrectionTest, StaysNearAPoseThatIsFarOff) {
  const Rgb8Image picture = PictureOf(mesh_, camera_, kVillagePose, 1);
  const glm::dmat4 stated = Moved(kVillagePose, RadFromDeg(8.0), 1.0, 2);
  const PoseCorrection found = Correct({&picture, 1}, stated);
  EXPECT_LT(OffPx(found.camera_from_world), 1.2 * OffPx(stated));
  EXPECT_LT(found.shift_px, 8.0);
}

TEST_F(PoseCorrectionTest, PicturesWithoutEdgesChangeNothing) {
  const Rgb8Image even(320, 240, glm::u8vec3(90));
  EXPECT_FALSE(Correct({&even, 1}, kVillagePose).corrected);
  // The sky.
  const PoseCorrection away = Correct({&even, 1}, LookAt({0.8, -5.0, 1.7}, {0.8, -4.0, 9.0}));
  EXPECT_FALSE(away.corrected);
  EXPECT_THAT(away.reason, HasSubstr("hardly an edge"));
  // Noise.
  Rgb8Image leaves(320, 240);
  std::mt19937 random(3);
  for (glm::u8vec3& pixel : leaves.pixels) {
    pixel = glm::u8vec3(static_cast<std::uint8_t>(random() % 256));
  }
  EXPECT_FALSE(Correct({&leaves, 1}, kVillagePose).corrected);
  cv::Mat view(240, 320, CV_8UC3, leaves.pixels.data());
  cv::GaussianBlur(view, view, {}, 2.0);
  cv::normalize(view, view, 0, 255, cv::NORM_MINMAX);
  EXPECT_FALSE(Correct({&leaves, 1}, kVillagePose).corrected);
  // No mesh.
  EXPECT_FALSE(CorrectPoseByEdges(lens_, {&even, 1}, {{}, rays_}, kVillagePose).corrected);
}

TEST_F(PoseCorrectionTest, RefusesWhatDoesNotFit) {
  const Rgb8Image small(20, 20);
  EXPECT_THROW(Correct({&small, 1}, kVillagePose), std::invalid_argument);
  EXPECT_THROW(Correct({}, kVillagePose), std::invalid_argument);
  for (const auto set : {+[](PoseCorrectionOptions& o) { o.rotation_sigma_rad = 0.0; },
                         +[](PoseCorrectionOptions& o) { o.position_sigma_m = NAN; },
                         +[](PoseCorrectionOptions& o) { o.least_shift_px = -1.0; },
                         +[](PoseCorrectionOptions& o) { o.reach_px = 1.0; }}) {
    PoseCorrectionOptions options;
    set(options);
    EXPECT_THROW(options.Validate(), std::invalid_argument);
  }
}

}  // namespace
}  // namespace pleinair::pose_correction_test
