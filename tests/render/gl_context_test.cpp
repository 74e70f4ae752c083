#include "render/gl_context.h"

#include <memory>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "composite_scene.h"
#include "render/compositor.h"
#include "test_scenes.h"

namespace pleinair::gl_context_test {
namespace {

TEST(HeadlessContext, GivesBothKindsOfOpenGlWithoutADisplay) {
  {
    const HeadlessContext desktop(GlApi::kDesktop45);
    EXPECT_THAT(desktop.Describe().version, testing::HasSubstr("4."));
    EXPECT_FALSE(desktop.Describe().renderer.empty());
  }
  const HeadlessContext es(GlApi::kEs31);
  EXPECT_THAT(es.Describe().version, testing::HasSubstr("OpenGL ES 3."));
}

TEST(HeadlessContext, MayGoBeforeTheCompositorThatDrewInIt) {
  auto context = std::make_unique<HeadlessContext>();
  auto compositor = std::make_unique<Compositor>();
  context.reset();
  compositor.reset();
}

// The rest of a run goes on with an error, not with a crash, and a new compositor works.
TEST(Compositor, SaysSoWhereItsContextIsGoneOrAnotherIsCurrent) {
  auto context = std::make_unique<HeadlessContext>();
  Compositor compositor;
  const test::CompositeScene scene(test::DirectionOf(215.0, 40.0), 32, 24);
  const auto message = [&] {
    try {
      compositor.Render(scene.Input({}));
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(message(), "");
  const auto other = std::make_unique<HeadlessContext>();
  EXPECT_THAT(message(), testing::HasSubstr("not current"));
  EXPECT_THROW(compositor.SetObjects({}), std::runtime_error);
  Compositor again;
  EXPECT_NO_THROW(again.Render(scene.Input({})));
  context.reset();
  EXPECT_THAT(message(), testing::HasSubstr("not current"));
}

TEST(Compositor, RefusesToStartWithoutAContext) { EXPECT_THROW(Compositor(), std::runtime_error); }

}  // namespace
}  // namespace pleinair::gl_context_test
