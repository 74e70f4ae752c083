#include "render/internal/shadow_mask_pass.h"

#include <vector>

#include <glm/vec4.hpp>

namespace pleinair {
namespace {

constexpr std::string_view kOneFragmentShader = R"(
out vec4 o_value;
void main() { o_value = vec4(1.0); }
)";

}  // namespace

ShadowMaskPass::ShadowMaskPass()
    : target_("shadow mask", GL_RGBA8, FrameBuffer::DepthStencil::kDepth24Stencil8),
      one_program_("shadow mask", kPositionVertexShader, kOneFragmentShader),
      sunlit_indices_(MakeBuffer()) {}

void ShadowMaskPass::DrawSunlitSides(const ShadowCaster& caster,
                                     const CasterBuffers& buffers,
                                     const glm::dvec3& to_sun) {
  std::vector<std::int8_t> facing;
  caster.Facing(to_sun, facing);
  std::vector<glm::uvec3> sunlit;
  for (std::size_t t = 0; t < facing.size(); ++t) {
    if (facing[t] > 0) sunlit.push_back(caster.Triangles()[t]);
  }
  const std::size_t front_count = sunlit.size();
  for (std::size_t t = 0; t < facing.size(); ++t) {
    if (facing[t] < 0) sunlit.push_back(caster.Triangles()[t]);
  }
  UploadBuffer(sunlit_indices_, GL_ARRAY_BUFFER, sunlit, GL_STREAM_DRAW);
  glCullFace(GL_BACK);
  buffers.DrawTriangles(sunlit_indices_, 0, front_count);
  glCullFace(GL_FRONT);
  buffers.DrawTriangles(sunlit_indices_, front_count, sunlit.size() - front_count);
}

Gray8Image ShadowMaskPass::Draw(const LayerView& view,
                                SceneGeometry& scene,
                                const glm::dvec3& to_sun,
                                VolumeStencil& stencil) {
  const int width = view.intrinsics.width_px;
  const int height = view.intrinsics.height_px;
  const glm::mat4 clip_from_local(view.clip_from_local);
  target_.Resize(width, height);
  ResetPassState();
  target_.Bind();
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  glEnable(GL_DEPTH_TEST);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  stencil.DrawSurface(scene.PhantomBuffers(), clip_from_local);
  stencil.DrawSurface(scene.ObjectBuffers(), clip_from_local);

  ShadowVolumes volumes;
  stencil.Begin(clip_from_local, view.ClipOfInfinity(to_sun));
  scene.Phantom().BuildVolumes(to_sun, std::nullopt, volumes);
  scene.PhantomBuffers().UploadVolumes(volumes);
  stencil.Draw(scene.PhantomBuffers(), volumes, VolumeStencil::Caps::kNeverInFront);
  scene.ObjectsAsCaster().BuildVolumes(to_sun, std::nullopt, volumes);
  scene.ObjectBuffers().UploadVolumes(volumes);
  stencil.Draw(scene.ObjectBuffers(), volumes, VolumeStencil::Caps::kNeverInFront);
  stencil.Finish();

  glStencilFunc(GL_NOTEQUAL, 0, 0xff);
  glDepthFunc(GL_EQUAL);
  glDepthMask(GL_FALSE);
  glEnable(GL_CULL_FACE);
  one_program_.Use();
  one_program_.Set("u_clip_from_local", clip_from_local);
  one_program_.Set("u_clip_of_infinity", glm::vec4(0.0f));
  DrawSunlitSides(scene.Phantom(), scene.PhantomBuffers(), to_sun);
  DrawSunlitSides(scene.ObjectsAsCaster(), scene.ObjectBuffers(), to_sun);

  // RGBA bytes can be read back from any device.
  std::vector<glm::u8vec4> values(static_cast<std::size_t>(width) *
                                  static_cast<std::size_t>(height));
  target_.BindForReading();
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, values.data());
  Gray8Image mask(width, height);
  for (std::size_t i = 0; i < values.size(); ++i) mask.pixels[i] = values[i].r;
  return mask;
}

}  // namespace pleinair
