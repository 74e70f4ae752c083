#include "calib/edge_pose.h"

#include <cmath>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "sunmodel/angles.h"
#include "tests/calib/marker_scene.h"
#include "tests/calib/village_scene.h"

namespace pleinair::edge_pose_test {
namespace {

using testing::HasSubstr;

// The village with doubled frames before its walls: edges in parallel, 4 cm apart, 3 px in a
// picture of 640 x 480.
Mesh FramedVillage() {
  Mesh mesh = Village();
  for (const glm::vec2& at_m : {glm::vec2(-3.7f, 0.4f), glm::vec2(-2.3f, 1.6f)}) {
    AddBox(mesh, {at_m.x, 3.98f, at_m.y}, {at_m.x + 1.1f, 4.0f, at_m.y + 0.9f});
    AddBox(mesh, {at_m.x + 0.04f, 3.96f, at_m.y + 0.04f}, {at_m.x + 1.06f, 3.98f, at_m.y + 0.86f});
  }
  AddBox(mesh, {1.0f, 5.98f, 0.5f}, {3.0f, 6.0f, 3.0f});
  AddBox(mesh, {1.04f, 5.96f, 0.54f}, {2.96f, 5.98f, 2.96f});
  return mesh;
}

const glm::dmat4& kPose = kVillagePose;

// Rough by 1 deg and 10 cm: some 15 px here.
TEST(EdgePose, FindsThePoseOfThePicture) {
  const Mesh mesh = Village();
  const RayCaster rays(mesh);
  const Lens lens(MarkerCamera());
  const std::vector<MeshEdge> edges = EdgesOf(mesh, rays);
  EXPECT_EQ(edges.size(), 48u);  // Twelve of each box: no diagonals.
  const Rgb8Image picture = PictureOf(mesh, FineCamera(lens), kPose, 1);
  double squares = 0.0;
  constexpr int kDraws = 2;
  for (unsigned seed = 0; seed < kDraws; ++seed) {
    const glm::dmat4 rough = Moved(kPose, RadFromDeg(1.0), 0.1, seed);
    const auto found = RefinePoseByEdges(lens, picture, {edges, rays}, rough);
    ASSERT_TRUE(found) << found.error().reason;
    EXPECT_LT(RotationBetweenRad(found->camera_from_world, kPose), RadFromDeg(0.1)) << seed;
    const double off_m = glm::distance(CentreOfPose(found->camera_from_world), CentreOfPose(kPose));
    EXPECT_LT(off_m, 0.03) << seed;
    EXPECT_LT(found->rms_px, 0.8);
    EXPECT_GT(found->found_share, found->chance_share + 0.2);
    squares += std::pow(off_m / found->position_sigma_m, 2.0) / kDraws;
  }
  // One picture: its error is one draw of the deviation that is stated for it.
  EXPECT_LT(squares, 9.0);
}

// Pictures of villages whose corners are off the mesh's by 1 or 2 cm, each from another
// place: the errors about and along the camera's axes lie within the stated deviations as often as
// they should. The two boxes of a doubled frame are off together, and begin edges with other ends.
class EdgePoseDeviation : public testing::TestWithParam<bool> {};

TEST_P(EdgePoseDeviation, StatesHowFarOffItIs) {
  const bool has_frames = GetParam();
  const Mesh mesh = has_frames ? FramedVillage() : Village();
  const RayCaster rays(mesh);
  const Lens lens(HalfSize(MarkerCamera()));
  const FineCamera fine_camera(lens);
  std::vector<MeshEdge> edges = EdgesOf(mesh, rays);
  constexpr std::size_t kOfABox = 12;
  for (std::size_t i = 0; has_frames && i < edges.size(); ++i) {
    if (i / kOfABox % 2 == 1) std::swap(edges[i].from_m, edges[i].to_m);
  }
  EdgePoseOptions options;
  options.reach_px = 12.0;
  constexpr unsigned kDraws = 24;
  int within_one = 0;
  int within_two = 0;
  for (unsigned seed = 0; seed < kDraws; ++seed) {
    std::mt19937 random(1000 + seed);
    std::normal_distribution<double> normal(0.0, 1.0);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    Mesh real = mesh;
    constexpr std::size_t kCorners = 8;
    constexpr std::size_t kBoxesOfTheVillage = 4;
    const double off_m = seed % 2 == 0 ? 0.01 : 0.02;
    // The lawn stays.
    for (std::size_t i = kCorners; i < real.positions_m.size(); ++i) {
      const std::size_t box = i / kCorners;
      if (box >= kBoxesOfTheVillage && box % 2 == 1) {
        const std::size_t outer = i - kCorners;
        real.positions_m[i] += real.positions_m[outer] - mesh.positions_m[outer];
        continue;
      }
      for (int c = 0; c < 3; ++c) {
        real.positions_m[i][c] += static_cast<float>(off_m * normal(random));
      }
    }
    const double x_m = 0.8 + 2.0 * uniform(random);
    const double y_m = -5.0 + uniform(random);
    const double z_m = 1.7 + 0.5 * uniform(random);
    const glm::dmat4 pose = LookAt({x_m, y_m, z_m}, {0.5 * uniform(random), 5.0, 1.3});
    const auto found = RefinePoseByEdges(lens,
                                         PictureOf(real, fine_camera, pose, seed),
                                         {edges, rays},
                                         Moved(pose, RadFromDeg(0.6), 0.06, seed),
                                         options);
    ASSERT_TRUE(found) << found.error().reason;
    const glm::dmat4 turn = found->camera_from_world * glm::inverse(pose);
    const glm::dvec3 turned_rad =
        0.5 * glm::dvec3(turn[1][2] - turn[2][1], turn[2][0] - turn[0][2], turn[0][1] - turn[1][0]);
    const glm::dvec3 moved_m =
        glm::dmat3(pose) * (CentreOfPose(found->camera_from_world) - CentreOfPose(pose));
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sigmas : {turned_rad[axis] / found->axis_rotation_sigma_rad[axis],
                                  moved_m[axis] / found->axis_position_sigma_m[axis]}) {
        within_one += std::abs(sigmas) < 1.0 ? 1 : 0;
        within_two += std::abs(sigmas) < 2.0 ? 1 : 0;
      }
    }
  }
  // A normal error's shares, to 10 and 5 points.
  EXPECT_NEAR(within_one / (6.0 * kDraws), 0.68, 0.10);
  EXPECT_NEAR(within_two / (6.0 * kDraws), 0.95, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Frames, EdgePoseDeviation, testing::Bool());

// Close edges in parallel are displaced together, whichever of its ends an edge begins with.
TEST(EdgePose, DeviationIsTheSameWhereEdgesBeginWithTheOtherEnd) {
  const Mesh mesh = FramedVillage();
  const RayCaster rays(mesh);
  const Lens lens(MarkerCamera());
  std::vector<MeshEdge> edges = EdgesOf(mesh, rays);
  const Rgb8Image picture = PictureOf(mesh, FineCamera(lens), kPose, 1);
  const glm::dmat4 rough = Moved(kPose, RadFromDeg(0.3), 0.03, 1);
  const auto found = RefinePoseByEdges(lens, picture, {edges, rays}, rough);
  ASSERT_TRUE(found) << found.error().reason;
  std::mt19937 random(1);
  for (int draw = 0; draw < 3; ++draw) {
    for (MeshEdge& edge : edges) {
      if (random() % 2 == 0) std::swap(edge.from_m, edge.to_m);
    }
    const auto swapped = RefinePoseByEdges(lens, picture, {edges, rays}, rough);
    ASSERT_TRUE(swapped) << swapped.error().reason;
    // Samples lie elsewhere on the edges, by up to half a step: 4 %. Displacements that cancel
    // would make 18 to 39 % of difference.
    EXPECT_NEAR(swapped->position_sigma_m / found->position_sigma_m, 1.0, 0.10);
    EXPECT_NEAR(swapped->rotation_sigma_rad / found->rotation_sigma_rad, 1.0, 0.10);
  }
}

TEST(EdgePose, SaysWhyThereIsNone) {
  const Mesh mesh = Village();
  const RayCaster rays(mesh);
  const Lens lens(MarkerCamera());
  const std::vector<MeshEdge> edges = EdgesOf(mesh, rays);
  const auto reason = [&](const Rgb8Image& picture, const glm::dmat4& pose) {
    const auto found = RefinePoseByEdges(lens, picture, {edges, rays}, pose);
    return found ? std::string("found") : found.error().reason;
  };
  const Rgb8Image picture = PictureOf(mesh, FineCamera(lens), kPose, 1);
  // The sky; nothing but noise; leaves everywhere.
  EXPECT_THAT(reason(picture, LookAt({0.8, -5.0, 1.7}, {0.8, -4.0, 9.0})),
              HasSubstr("hardly an edge of the mesh in view"));
  EXPECT_THAT(reason(Rgb8Image(640, 480, glm::u8vec3(90)), kPose),
              HasSubstr("cannot be determined from edges"));
  Rgb8Image leaves(640, 480);
  std::mt19937 random(3);
  for (glm::u8vec3& pixel : leaves.pixels) {
    pixel = glm::u8vec3(static_cast<std::uint8_t>(random() % 256));
  }
  cv::Mat view(480, 640, CV_8UC3, leaves.pixels.data());
  cv::GaussianBlur(view, view, {}, 2.0);
  cv::normalize(view, view, 0, 255, cv::NORM_MINMAX);
  EXPECT_THAT(reason(leaves, kPose), HasSubstr("cannot be determined from edges"));
  // From 90 deg away.
  EXPECT_THAT(reason(picture, LookAt({10.0, 5.0, 1.7}, {0.0, 5.0, 1.3})),
              HasSubstr("cannot be determined from edges"));
  EXPECT_THROW(RefinePoseByEdges(lens, Rgb8Image(20, 20), {edges, rays}, kPose),
               std::invalid_argument);
}

// One bright pole: the camera may move along it and about it.
TEST(EdgePose, EdgesOfOneDirectionLeaveItOpen) {
  Mesh mesh;
  mesh.materials.resize(1);
  AddBox(mesh, {-0.3f, 4, -20}, {0.3f, 4.5f, 20});
  const RayCaster rays(mesh);
  const Lens lens(MarkerCamera());
  const Rgb8Image picture = PictureOf(mesh, FineCamera(lens), kPose, 1);
  const auto found = RefinePoseByEdges(
      lens, picture, {EdgesOf(mesh, rays), rays}, Moved(kPose, RadFromDeg(0.3), 0.02, 1));
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().reason, HasSubstr("the edges leave it open to"));
}

// A row of equal posts fits its picture shifted by a post nearly as well.
TEST(EdgePose, TwoPosesThatFitAreRefused) {
  Mesh mesh;
  mesh.materials.resize(1);
  for (int i = -40; i < 40; ++i) {
    const float x = 0.3f * static_cast<float>(i);
    AddBox(mesh, {x, 4.0f, 0}, {x + 0.1f, 4.1f, 2.0f});
  }
  const RayCaster rays(mesh);
  const Lens lens(MarkerCamera());
  const glm::dmat4 pose = LookAt({0.0, 0.0, 1.2}, {0.0, 4.0, 1.0});
  // Half way between two.
  const glm::dmat4 rough = glm::translate(glm::dmat4(1.0), glm::dvec3(0.15, 0.0, 0.0)) * pose;
  EdgePoseOptions options;
  options.reach_px = 40.0;
  const auto found = RefinePoseByEdges(lens,
                                       PictureOf(mesh, FineCamera(lens), pose, 1),
                                       {EdgesOf(mesh, rays), rays},
                                       rough,
                                       options);
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().reason, HasSubstr("two poses fit the edges nearly as well"));
  EXPECT_EQ(found.error().candidates.size(), 2u);
}

// A floor of two slabs that share no corner: the seam is no edge, nor is the diagonal.
TEST(MeshEdges, SeamsOfAPlaneAreNone) {
  Mesh mesh;
  mesh.materials.resize(2);
  mesh.positions_m = {
      {0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {2, -1, 0}, {4, -1, 0}, {4, 3, 0}, {2, 3, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  mesh.triangle_material = {0, 0, 0, 0};
  // Three ends of the first, three of the second, and the second's seam, which is longer.
  EXPECT_EQ(EdgesOf(mesh, RayCaster(mesh)).size(), 6u);
  mesh.triangle_material = {0, 0, 1, 1};
  EXPECT_EQ(EdgesOf(mesh, RayCaster(mesh)).size(), 8u);
}

}  // namespace
}  // namespace pleinair::edge_pose_test
