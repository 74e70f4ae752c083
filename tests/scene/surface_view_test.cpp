#include "scene/surface_view.h"

#include <gtest/gtest.h>

namespace pleinair::surface_view_test {
namespace {

SurfaceView OnePixel(const glm::vec3& normal, float visibility, const glm::vec3& bounce) {
  SurfaceView view;
  view.region = Image<std::int32_t>(1, 1, 0);
  view.normal_world = Image<glm::vec3>(1, 1, normal);
  view.sun_visibility = Image<float>(1, 1, visibility);
  view.sun_bounce = Image<glm::vec3>(1, 1, bounce);
  return view;
}

// The model's S = s max(0, n.l) + s_bounce, with values that single precision holds exactly.
TEST(SurfaceView, SunResponseIsVisibleCosinePlusBounce) {
  const SurfaceView view = OnePixel({0.0f, 0.0f, 1.0f}, 0.5f, {0.25f, 0.125f, 0.0f});
  EXPECT_EQ(SunResponse(view, 0, {0.6, 0.0, 0.8}),
            glm::vec3(0.4f) + glm::vec3(0.25f, 0.125f, 0.0f));
}

TEST(SurfaceView, ASurfaceTurnedAwayGetsTheBounceOnly) {
  const SurfaceView view = OnePixel({0.0f, 0.0f, -1.0f}, 1.0f, glm::vec3(0.25f));
  EXPECT_EQ(SunResponse(view, 0, {0.0, 0.0, 1.0}), glm::vec3(0.25f));
}

}  // namespace
}  // namespace pleinair::surface_view_test
