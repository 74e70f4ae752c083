#include "shadow_mask.h"

#include <optional>
#include <string_view>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

namespace pleinair::test {
namespace {

constexpr std::string_view kOneFragmentShader = R"(
out vec4 o_value;
void main() { o_value = vec4(1.0); }
)";

// The triangles whose front, or whose back, faces the sun.
ShadowCaster FacingTheSun(const ShadowCaster& caster, const glm::dvec3& to_sun, bool by_front) {
  std::vector<glm::uvec3> triangles;
  for (const glm::uvec3& triangle : caster.Triangles()) {
    const glm::dvec3 a(caster.Positions()[triangle.x]);
    const glm::dvec3 b(caster.Positions()[triangle.y]);
    const glm::dvec3 c(caster.Positions()[triangle.z]);
    const double height = glm::dot(glm::cross(b - a, c - a), to_sun);
    if (by_front ? height > 0.0 : height < 0.0) triangles.push_back(triangle);
  }
  return {caster.Positions(), triangles};
}

}  // namespace

ShadowMask::ShadowMask()
    : target_("shadow mask", GL_RGBA8, FrameBuffer::DepthStencil::kDepth24Stencil8),
      one_program_("shadow mask", kPositionVertexShader, kOneFragmentShader) {}

void ShadowMask::DrawSunlitSides(const ShadowCaster& caster,
                                 const glm::mat4& clip_from_local,
                                 const glm::dvec3& to_sun) {
  for (const bool by_front : {true, false}) {
    sunlit_.UploadSurface(FacingTheSun(caster, to_sun, by_front));
    glCullFace(by_front ? GL_BACK : GL_FRONT);
    sunlit_.DrawSurface(clip_from_local);
  }
}

Gray8Image ShadowMask::Draw(const Camera& camera, const glm::dvec3& to_sun) {
  const ApplicationState application_state;
  const LayerView view = MakeLayerView(scene_, camera, camera.intrinsics);
  const int width = view.intrinsics.width_px;
  const int height = view.intrinsics.height_px;
  const glm::mat4 clip_from_local(view.clip_from_local);
  target_.Resize(width, height);
  ResetPassState();
  target_.Bind();
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  glEnable(GL_DEPTH_TEST);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  stencil_.DrawSurface(scene_.PhantomBuffers(), clip_from_local);
  stencil_.DrawSurface(scene_.ObjectBuffers(), clip_from_local);

  ShadowVolumes volumes;
  stencil_.Begin(clip_from_local, view.ClipOfInfinity(to_sun));
  scene_.Phantom().BuildVolumes(to_sun, std::nullopt, volumes);
  scene_.PhantomBuffers().UploadVolumes(volumes);
  stencil_.Draw(scene_.PhantomBuffers(), volumes, VolumeStencil::Caps::kNeverInFront);
  scene_.ObjectsAsCaster().BuildVolumes(to_sun, std::nullopt, volumes);
  scene_.ObjectBuffers().UploadVolumes(volumes);
  stencil_.Draw(scene_.ObjectBuffers(), volumes, VolumeStencil::Caps::kNeverInFront);
  stencil_.Finish();

  glStencilFunc(GL_NOTEQUAL, 0, 0xff);
  glDepthFunc(GL_EQUAL);
  glDepthMask(GL_FALSE);
  glEnable(GL_CULL_FACE);
  one_program_.Use();
  one_program_.Set("u_clip_from_local", clip_from_local);
  one_program_.Set("u_clip_of_infinity", glm::vec4(0.0f));
  DrawSunlitSides(scene_.Phantom(), clip_from_local, to_sun);
  DrawSunlitSides(scene_.ObjectsAsCaster(), clip_from_local, to_sun);

  // RGBA bytes can be read back from any device.
  std::vector<glm::u8vec4> values(static_cast<std::size_t>(width) *
                                  static_cast<std::size_t>(height));
  target_.BindForReading();
  glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, values.data());
  Gray8Image mask(width, height);
  for (std::size_t i = 0; i < values.size(); ++i) mask.pixels[i] = values[i].r;
  return mask;
}

}  // namespace pleinair::test
