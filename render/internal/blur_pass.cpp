#include "render/internal/blur_pass.h"

#include <string_view>

namespace pleinair {
namespace {

constexpr std::string_view kBlurShader = R"(
uniform sampler2D u_layer;
uniform ivec2 u_direction;
uniform ivec4 u_rect;  // Lower corner and the last pixel: what is defined of the layer.
uniform int u_reach;
uniform float u_weights[25];  // BlurKernel::kMostReachPx and the middle.
uniform float u_least;
out vec4 o_colour;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  ivec2 last = textureSize(u_layer, 0) - 1;
  vec4 sum = vec4(0.0);
  for (int i = -u_reach; i <= u_reach; ++i) {
    ivec2 at = clamp(pixel + i * u_direction, ivec2(0), last);
    if (all(greaterThanEqual(at, u_rect.xy)) && all(lessThanEqual(at, u_rect.zw))) {
      sum += u_weights[abs(i)] * texelFetch(u_layer, at, 0);
    }
  }
  o_colour = sum.a < u_least ? vec4(0.0) : sum;
}
)";

}  // namespace

BlurPass::BlurPass()
    : one_way_("layer blurred one way", GL_RGBA16F, FrameBuffer::DepthStencil::kNone),
      both_ways_("layer blurred", GL_RGBA16F, FrameBuffer::DepthStencil::kNone),
      program_("layer blur", kScreenVertexShader, kBlurShader),
      no_vertices_(MakeVertexArray()) {}

void BlurPass::Draw(
    GLuint layer, const PixelRect& rect, const BlurKernel& kernel, int width, int height) {
  if (rect.Empty()) return;
  ResetPassState();
  both_ways_.Resize(width, height);
  both_ways_.Bind();
  glClear(GL_COLOR_BUFFER_BIT);
  program_.Use();
  program_.Set("u_layer", 0);
  program_.Set("u_reach", kernel.ReachPx());
  program_.SetArray("u_weights", kernel.Weights());
  glActiveTexture(GL_TEXTURE0);
  glBindVertexArray(no_vertices_.Name());
  const PixelRect spread = kernel.Spread(rect, width, height);
  struct Source {
    GLuint texture;
    PixelRect rect;  // Zero elsewhere.
  };
  const auto draw = [&](FrameBuffer& target,
                        const PixelRect& to,
                        const Source& from,
                        const glm::ivec2& direction,
                        float least) {
    target.Resize(width, height);
    target.Bind();
    ScissorTo(to);
    glBindTexture(GL_TEXTURE_2D, from.texture);
    program_.Set("u_direction", direction);
    program_.Set("u_rect", glm::ivec4(from.rect.lower, from.rect.upper - 1));
    program_.Set("u_least", least);
    DrawScreen();
  };
  const PixelRect rows{{spread.lower.x, rect.lower.y}, {spread.upper.x, rect.upper.y}};
  draw(one_way_, rows, {layer, rect}, {1, 0}, 0.0f);
  constexpr float kLeastCoverage = 1.0f / 512.0f;  // A quarter of a code value in white.
  draw(both_ways_, spread, {one_way_.ColourTexture(), rows}, {0, 1}, kLeastCoverage);
  glBindTexture(GL_TEXTURE_2D, 0);
}

}  // namespace pleinair
