#include "render/internal/gl_object.h"

#include <utility>

#include "render/internal/current_context.h"

namespace pleinair {

GlObject::GlObject(GLuint name, Deleter deleter)
    : name_(name), deleter_(deleter), context_(CurrentContext()) {}

GlObject::~GlObject() { Reset(); }

GlObject::GlObject(GlObject&& other) noexcept
    : name_(std::exchange(other.name_, 0)), deleter_(other.deleter_), context_(other.context_) {}

GlObject& GlObject::operator=(GlObject&& other) noexcept {
  if (this != &other) {
    Reset();
    name_ = std::exchange(other.name_, 0);
    deleter_ = other.deleter_;
    context_ = other.context_;
  }
  return *this;
}

void GlObject::Reset() {
  if (name_ != 0 && CurrentContext() == context_) deleter_(name_);
  name_ = 0;
}

GlObject MakeBuffer() {
  GLuint name = 0;
  glGenBuffers(1, &name);
  return {name, [](GLuint dead) { glDeleteBuffers(1, &dead); }};
}

GlObject MakeVertexArray() {
  GLuint name = 0;
  glGenVertexArrays(1, &name);
  return {name, [](GLuint dead) { glDeleteVertexArrays(1, &dead); }};
}

GlObject MakeTexture() {
  GLuint name = 0;
  glGenTextures(1, &name);
  return {name, [](GLuint dead) { glDeleteTextures(1, &dead); }};
}

GlObject MakeRenderbuffer() {
  GLuint name = 0;
  glGenRenderbuffers(1, &name);
  return {name, [](GLuint dead) { glDeleteRenderbuffers(1, &dead); }};
}

GlObject MakeFramebuffer() {
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  return {name, [](GLuint dead) { glDeleteFramebuffers(1, &dead); }};
}

GlObject MakeShader(GLenum stage) {
  return {glCreateShader(stage), [](GLuint dead) { glDeleteShader(dead); }};
}

GlObject MakeProgram() {
  return {glCreateProgram(), [](GLuint dead) { glDeleteProgram(dead); }};
}

GlObject MakeQuery() {
  GLuint name = 0;
  glGenQueries(1, &name);
  return {name, [](GLuint dead) { glDeleteQueries(1, &dead); }};
}

}  // namespace pleinair
