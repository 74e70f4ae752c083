#include "render/internal/object_layer_pass.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include <glm/vec4.hpp>

#include "render/internal/object_by_place_shaders.h"
#include "render/internal/object_layer_shaders.h"
#include "render/internal/view_projection.h"
#include "scene/textured_material.h"

namespace pleinair {
namespace {

// Binds a texture over part of a picture whose own part starts at `first`.
template <typename Texel>
void BindRect(const ShaderProgram& program,
              const char* texture_uniform,
              const char* rect_uniform,
              const RectTexture<Texel>& texture,
              const glm::ivec2& first) {
  const PixelRect& rect = texture.Rect();
  program.Set(texture_uniform, 0);
  program.Set(rect_uniform, glm::ivec4(rect.lower - first, rect.upper - rect.lower));
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture.Texture());
}

glm::dmat4 ClipOfSamples(const LayerView& view, const SampleLattice& lattice) {
  const PixelRect& rect = view.object_rect;
  return lattice.ClipFromPixelsClip() * ClipOfRect(view.intrinsics, rect.lower, rect.upper) *
         view.clip_from_local;
}

void SetLattice(const ShaderProgram& program, const SampleLattice& lattice) {
  program.Set("u_lattice", glm::ivec3(lattice.Side(), lattice.Turn(), lattice.Pixels().x));
}

template <typename... Parts>
std::string Joined(const Parts&... parts) {
  return (std::string(parts) + ...);
}

const ShaderProgram& MadeByPlace(std::optional<ShaderProgram>& program,
                                 const char* name,
                                 const std::string& fragment) {
  if (!program) program.emplace(name, kByPlaceVertexShader, fragment);
  return *program;
}

// Sets the material of the program in use; its picture is on unit 1.
void SetMaterial(const ShaderProgram& program,
                 const TexturedMaterial& material,
                 TextureStore& textures) {
  int last_level = -1;
  if (material.texture) {
    glActiveTexture(GL_TEXTURE1);
    last_level = textures.Bind(*material.texture, material.wraps);
    glActiveTexture(GL_TEXTURE0);
  }
  program.Set("u_picture", 1);
  program.Set("u_last_level", last_level);
  program.Set("u_base_colour", glm::vec4(material.base_colour, material.base_alpha));
  program.Set("u_metallic", material.metallic);
  program.Set("u_dielectric_reflectance", material.dielectric_reflectance);
  program.Set("u_max_albedo", TexturedMaterial::kMaxAlbedo);
  program.Set("u_alpha_cutoff", material.alpha_cutoff);
}

void UnbindPictures() {
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, 0);
}

// Real surfaces, seen from either side.
void DrawWhatHides(const glm::mat4& clip_from_local,
                   SceneGeometry& scene,
                   const VolumeStencil& stencil) {
  glEnable(GL_DEPTH_TEST);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  stencil.DrawSurface(scene.PhantomBuffers(), clip_from_local);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthFunc(GL_LEQUAL);  // On a real surface of the same depth the object wins.
}

}  // namespace

SampleLattice ObjectLayerPass::LatticeOf(const PixelRect& rect, int wanted_side) {
  constexpr std::int64_t kMostSamples = std::int64_t{1} << 22;
  const std::int64_t pixels = std::int64_t{rect.Width()} * rect.Height();
  int side = wanted_side;
  while (side > 2 && pixels * (side * side + 1) > kMostSamples) side -= 2;
  return {side, {rect.Width(), rect.Height()}};
}

ObjectLayerPass::ObjectLayerPass(int samples_per_side, bool keeps_samples)
    : wanted_samples_per_side_(samples_per_side),
      keeps_samples_(keeps_samples),
      samples_("object samples", GL_RGBA16F, FrameBuffer::DepthStencil::kDepth24Stencil8),
      triangles_("object triangles", GL_R32UI, FrameBuffer::DepthStencil::kNone),
      layer_("object layer",
             keeps_samples ? GL_RGBA32F : GL_RGBA16F,
             FrameBuffer::DepthStencil::kNone),
      sun_program_("object sun",
                   kObjectSunVertexShader,
                   Joined(kObjectPlaceOfSample, kObjectMaterial, kObjectSunFragmentShader)),
      mean_program_("object samples' mean", kScreenVertexShader, kObjectMeanFragmentShader),
      no_vertices_(MakeVertexArray()) {
  if (keeps_samples_) {
    triangle_program_.emplace(
        "object triangles", kObjectTriangleVertexShader, kObjectTriangleFragmentShader);
  } else {
    ambient_program_.emplace(
        "object ambient",
        kObjectAmbientVertexShader,
        Joined(kObjectPlaceOfSample, kObjectMirrored, kObjectAmbientFragmentShader));
  }
}

void ObjectLayerPass::Draw(const LayerView& view,
                           SceneGeometry& scene,
                           const LayerSun& sun,
                           const LayerLight& light,
                           VolumeStencil& stencil) {
  const PixelRect& rect = view.object_rect;
  const glm::ivec2 size_px(view.intrinsics.width_px, view.intrinsics.height_px);
  BeginLayer(size_px, rect);
  if (rect.Empty()) return;
  lattice_ = LatticeOf(rect, wanted_samples_per_side_);
  if (keeps_samples_) {
    const bool mirrors =
        light.mirrored != nullptr && !scene.ShadedObjects().TrianglesByPlace().empty();
    const KeptFor now{scene.Id(), view.clip_from_local, size_px, rect, mirrors};
    if (kept_for_ != now) {
      kept_for_.reset();
      FindShares(view, scene, stencil, mirrors);
      kept_for_ = now;
    }
    SumFromVertices(rect, scene, light);
    if (sun.is_shining) {
      BindSamples();
      glClear(GL_COLOR_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    }
  } else {
    DrawFromVertices(view, scene, light, stencil);
  }
  if (sun.is_shining) {
    DrawSun(view, scene, sun, light, stencil);
  }
  DrawMean(rect, sun.is_shining || !keeps_samples_);
}

void ObjectLayerPass::BeginLayer(const glm::ivec2& size_px, const PixelRect& rect) {
  ResetPassState();
  const bool is_resized = layer_.Resize(size_px.x, size_px.y);
  if (!is_resized && drawn_rect_ == rect) return;
  layer_.Bind();
  glClear(GL_COLOR_BUFFER_BIT);
  drawn_rect_ = rect;
}

void ObjectLayerPass::BindSamples() {
  const PixelRect sample_rect{{0, 0}, lattice_.Size()};
  samples_.Reserve(sample_rect.Width(), sample_rect.Height());
  samples_.Bind();
  glViewport(0, 0, sample_rect.Width(), sample_rect.Height());
  ScissorTo(sample_rect);
}

void ObjectLayerPass::DrawFromVertices(const LayerView& view,
                                       SceneGeometry& scene,
                                       const LayerLight& light,
                                       const VolumeStencil& stencil) {
  const PixelRect& rect = view.object_rect;
  scene.ShadedObjects().UploadIrradiance(light.vertex_irradiance, light.gain);
  mirrored_.Clear();
  if (light.mirrored != nullptr) {
    mirrored_.Update({light.mirrored->x_px, light.mirrored->y_px},
                     light.mirrored->radiance,
                     [](const glm::vec3& radiance) { return glm::vec4(radiance, 0.0f); });
  }
  BindSamples();
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  const glm::mat4 clip_from_local(ClipOfSamples(view, lattice_));
  DrawWhatHides(clip_from_local, scene, stencil);
  ObjectMesh& objects = scene.ShadedObjects();
  for (const ObjectMesh::Batch& batch : objects.Batches()) {
    if (batch.count == 0) continue;
    const ShaderProgram& program = batch.by_place
                                       ? MadeByPlace(ambient_by_place_,
                                                     "object ambient by place",
                                                     Joined(kByPlaceMaterial,
                                                            kObjectPlaceOfSample,
                                                            kObjectMirrored,
                                                            kByPlaceAmbientFragmentShader))
                                       : *ambient_program_;
    program.Use();
    const bool mirrors =
        light.mirrored != nullptr && (!batch.by_place || batch.by_place->IsGlossy());
    program.Set("u_clip_from_local", clip_from_local);
    program.Set("u_mirrors", mirrors ? 1 : 0);
    SetLattice(program, lattice_);
    program.Set("u_gain", light.gain);
    BindRect(program, "u_mirrored", "u_mirrored_rect", mirrored_, rect.lower);
    if (batch.by_place) SetMaterial(program, *batch.by_place, objects.Textures());
    objects.Draw(batch.first, batch.count);
  }
  UnbindPictures();
}

// As DrawFromVertices, with the triangles' numbers instead of their radiance.
void ObjectLayerPass::FindShares(const LayerView& view,
                                 SceneGeometry& scene,
                                 const VolumeStencil& stencil,
                                 bool mirrors) {
  const PixelRect sample_rect{{0, 0}, lattice_.Size()};
  BindSamples();
  triangles_.Resize(samples_.Width(), samples_.Height());
  triangles_.ShareDepthStencilOf(samples_);
  triangles_.Bind();
  glViewport(0, 0, sample_rect.Width(), sample_rect.Height());
  ScissorTo(sample_rect);
  const GLuint none[4] = {0, 0, 0, 0};
  glClearBufferuiv(GL_COLOR, 0, none);
  glClear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  const glm::mat4 clip_from_local(ClipOfSamples(view, lattice_));
  DrawWhatHides(clip_from_local, scene, stencil);
  ObjectMesh& objects = scene.ShadedObjects();
  std::size_t whole = objects.Triangles().size();
  for (const ObjectMesh::Batch& batch : objects.Batches()) {
    if (batch.is_cut_out) whole = std::min(whole, batch.first);
  }
  triangle_program_->Use();
  triangle_program_->Set("u_clip_from_local", clip_from_local);
  triangle_program_->Set("u_first_triangle", 0);
  objects.Draw(0, whole);
  for (const ObjectMesh::Batch& batch : objects.Batches()) {
    if (!batch.is_cut_out) continue;
    const ShaderProgram& program =
        MadeByPlace(triangle_by_place_,
                    "object triangles by place",
                    Joined(kByPlaceMaterial, kByPlaceTriangleFragmentShader));
    program.Use();
    program.Set("u_clip_from_local", clip_from_local);
    program.Set("u_first_triangle", static_cast<int>(batch.first));
    SetMaterial(program, *batch.by_place, objects.Textures());
    objects.Draw(batch.first, batch.count);
    UnbindPictures();
  }

  shares_ = VertexShares({.lattice = lattice_,
                          .triangle = reader_.ReadNumbers(triangles_, sample_rect),
                          .clip_from_position = clip_from_local,
                          .positions = objects.Positions(),
                          .triangles = objects.Triangles(),
                          .by_place = objects.TrianglesByPlace(),
                          .mirrors = mirrors},
                         objects.GlossyVertices());
  ResetPassState();
}

void ObjectLayerPass::SumFromVertices(const PixelRect& rect,
                                      SceneGeometry& scene,
                                      const LayerLight& light) {
  scene.ShadedObjects().RadianceAtVertices(
      light.vertex_irradiance, light.gain, light.mirrored != nullptr, at_vertices_);
  mirrored_at_pixels_.clear();
  if (light.mirrored != nullptr) {
    const RgbImage& mirrored = light.mirrored->radiance;
    for (int y = rect.lower.y; y < rect.upper.y; ++y) {
      for (int x = rect.lower.x; x < rect.upper.x; ++x) {
        const glm::ivec2 place(x - light.mirrored->x_px, y - light.mirrored->y_px);
        mirrored_at_pixels_.push_back(mirrored.Contains(place.x, place.y)
                                          ? light.gain * mirrored.At(place.x, place.y)
                                          : glm::vec3(0.0f));
      }
    }
  }
  from_vertices_.width = rect.Width();
  from_vertices_.height = rect.Height();
  shares_.Sum(at_vertices_, mirrored_at_pixels_, from_vertices_.pixels);
  from_vertices_texture_.Update(rect.lower, from_vertices_);
}

void ObjectLayerPass::DrawSun(const LayerView& view,
                              SceneGeometry& scene,
                              const LayerSun& sun,
                              const LayerLight& light,
                              VolumeStencil& stencil) {
  const PixelRect& rect = view.object_rect;
  const glm::mat4 clip_from_local(ClipOfSamples(view, lattice_));
  glEnable(GL_DEPTH_TEST);
  if (sun.of_objects != nullptr && sun.of_real != nullptr) {
    // All casters are in the depth buffer, so that no cap lies in front of what is visible.
    stencil.Begin(clip_from_local,
                  glm::vec4(ClipOfSamples(view, lattice_) * glm::dvec4(-sun.to_sun, 0.0)));
    stencil.Draw(scene.ObjectBuffers(), *sun.of_objects, VolumeStencil::Caps::kNeverInFront);
    stencil.Draw(scene.PhantomBuffers(), *sun.of_real, VolumeStencil::Caps::kNeverInFront);
    stencil.Finish();
  }
  // Each sample takes the sun once, also where faces are doubled.
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_EQUAL, 0, 0xff);
  glStencilOp(GL_KEEP, GL_KEEP, GL_INCR);
  // Shares know which samples the sun reaches: by the shading normals, on smooth surfaces. Else
  // whole triangles are turned to it or away.
  const bool by_shares = !light.seen_sun.Rect().Empty();
  if (!by_shares) {
    scene.ObjectsAsCaster().SidesThatMayBeSunlit(sun.to_sun, sunlit_sides_);
    scene.ShadedObjects().UploadSunlitTriangles(sunlit_sides_);
  }
  glDepthFunc(GL_EQUAL);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  if (!by_shares) glEnable(GL_CULL_FACE);
  ObjectMesh& objects = scene.ShadedObjects();
  for (const ObjectMesh::Batch& batch : objects.Batches()) {
    if (!by_shares && batch.front_count + batch.back_count == 0) continue;
    const ShaderProgram& program =
        batch.by_place
            ? MadeByPlace(sun_by_place_,
                          "object sun by place",
                          Joined(kByPlaceMaterial, kObjectPlaceOfSample, kObjectSunFragmentShader))
            : sun_program_;
    program.Use();
    program.Set("u_clip_from_local", clip_from_local);
    program.Set("u_camera", view.camera_centre_local);
    program.Set("u_to_sun", glm::vec3(sun.to_sun));
    program.Set("u_irradiance", sun.irradiance);
    program.Set("u_angular_radius", static_cast<float>(sun.angular_radius_rad));
    constexpr int kShareSide = ObjectSunShare::kSamplesPerSide;
    BindRect(program, "u_seen_sun", "u_seen_sun_rect", light.seen_sun, kShareSide * rect.lower);
    SetLattice(program, lattice_);
    program.Set("u_shares_per_side", kShareSide);
    if (batch.by_place) SetMaterial(program, *batch.by_place, objects.Textures());
    if (by_shares) {
      objects.Draw(batch.first, batch.count);
      continue;
    }
    glCullFace(GL_BACK);
    objects.DrawSunlit(batch.first_front, batch.front_count);
    glCullFace(GL_FRONT);
    objects.DrawSunlit(batch.first_back, batch.back_count);
  }
  UnbindPictures();
}

void ObjectLayerPass::DrawMean(const PixelRect& rect, bool has_samples) {
  ResetPassState();
  layer_.Bind();
  ScissorTo(rect);
  mean_program_.Use();
  mean_program_.Set("u_samples", 0);
  mean_program_.Set("u_from_vertices", 1);
  mean_program_.Set("u_has_from_vertices", keeps_samples_ ? 1 : 0);
  mean_program_.Set("u_lower", rect.lower);
  SetLattice(mean_program_, lattice_);
  mean_program_.Set("u_sample_count", has_samples ? lattice_.PerPixel() : 0);
  static_assert(SampleLattice::kMostPerPixel == 65);  // The shader's array.
  const std::vector<glm::vec2> offsets(lattice_.Offsets().begin(), lattice_.Offsets().end());
  mean_program_.SetArray("u_offsets", offsets);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, keeps_samples_ ? from_vertices_texture_.Texture() : 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, has_samples ? samples_.ColourTexture() : 0);
  glBindVertexArray(no_vertices_.Name());
  DrawScreen();
  glBindTexture(GL_TEXTURE_2D, 0);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, 0);
  glActiveTexture(GL_TEXTURE0);
}

}  // namespace pleinair
