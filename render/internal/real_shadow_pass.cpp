#include "render/internal/real_shadow_pass.h"

namespace pleinair {
namespace {

constexpr std::string_view kMaskFragmentShader = R"(
out float o_value;
void main() { o_value = 1.0; }
)";

}  // namespace

RealShadowPass::RealShadowPass()
    : target_("real shadow", GL_R8, FrameBuffer::DepthStencil::kDepth24Stencil8),
      one_program_("mask", kScreenVertexShader, kMaskFragmentShader),
      no_vertices_(MakeVertexArray()) {}

void RealShadowPass::Clear(int width, int height) {
  if (target_.Resize(width, height)) depth_of_scene_ = {};
  ResetPassState();
  target_.Bind();
  glClear(GL_COLOR_BUFFER_BIT);
}

void RealShadowPass::Draw(const LayerView& view,
                          const PixelRect& rect,
                          SceneGeometry& scene,
                          const SunVolumes& of_objects,
                          VolumeStencil& stencil) {
  Clear(view.intrinsics.width_px, view.intrinsics.height_px);
  if (depth_of_scene_ != scene.Id() || depth_clip_from_local_ != view.clip_from_local) {
    glClear(GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    stencil.DrawSurface(scene.PhantomBuffers(), glm::mat4(view.clip_from_local));
    depth_of_scene_ = scene.Id();
    depth_clip_from_local_ = view.clip_from_local;
  }
  ScissorTo(rect);
  glClear(GL_STENCIL_BUFFER_BIT);
  stencil.Begin(glm::mat4(view.clip_from_local), view.ClipOfInfinity(of_objects.to_sun));
  stencil.Draw(scene.ObjectBuffers(), of_objects.volumes, VolumeStencil::Caps::kTested);
  stencil.Finish();

  glDisable(GL_DEPTH_TEST);
  glStencilFunc(GL_NOTEQUAL, 0, 0xff);
  one_program_.Use();
  glBindVertexArray(no_vertices_.Name());
  DrawScreen();
}

}  // namespace pleinair
