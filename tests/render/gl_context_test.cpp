#include "render/gl_context.h"

#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/compositor.h"

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

TEST(Compositor, RefusesToStartWithoutAContext) { EXPECT_THROW(Compositor(), std::runtime_error); }

}  // namespace
}  // namespace pleinair::gl_context_test
