// Lines to other programs: a file, a pipe, and sockets whose readers come and go.
#include "apps/line_stream.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scene/temporary_folder.h"

namespace pleinair::line_stream_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

// A program that reads what a socket gives.
class Reader {
 public:
  explicit Reader(const fs::path& path) : socket_(socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path.c_str());
    if (connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      throw std::runtime_error(std::strerror(errno));
    }
  }
  ~Reader() { close(socket_); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  // What is there now; none where the other end has closed.
  std::optional<std::string> Read() {
    std::string text;
    std::array<char, 65536> part{};
    for (;;) {
      const ssize_t count = recv(socket_, part.data(), part.size(), MSG_DONTWAIT);
      if (count == 0 && text.empty()) return std::nullopt;
      if (count <= 0) return text;
      text.append(part.data(), static_cast<std::size_t>(count));
    }
  }

 private:
  int socket_;
};

class LineStreamTest : public testing::Test {
 protected:
  std::string SocketTarget() const { return "unix:" + Socket().string(); }
  fs::path Socket() const { return folder_ / "light.socket"; }
  std::string Refusal(const std::string& target) const {
    const std::string text = MessageOf([&] { const LineStream stream(target); });
    EXPECT_EQ(text.find('\n'), std::string::npos);
    return text;
  }

  TemporaryFolder folder_;
};

TEST_F(LineStreamTest, AFileHasEachLineAtOnce) {
  const fs::path file = folder_.Write("light.jsonl", "of an earlier run\n");
  LineStream stream(file.string());
  EXPECT_EQ(ContentOf(file), "of an earlier run\n");
  stream.Write("one");
  EXPECT_EQ(ContentOf(file), "one\n");
  stream.Write("two");
  EXPECT_EQ(ContentOf(file), "one\ntwo\n");
}

TEST_F(LineStreamTest, APipeWhoseReaderIsGoneIsAnError) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  LineStream stream(pipe.string());
  stream.Write("one");
  std::array<char, 16> text{};
  EXPECT_EQ(read(reader, text.data(), text.size()), 4);
  close(reader);
  EXPECT_THAT(MessageOf([&] { stream.Write("two"); }),
              AllOf(HasSubstr(pipe.string()), HasSubstr("its reader is gone")));
}

TEST_F(LineStreamTest, AFullDiscIsAnError) {
  LineStream stream("/dev/full");
  EXPECT_THAT(MessageOf([&] { stream.Write("one"); }), HasSubstr("/dev/full: No space left"));
}

TEST_F(LineStreamTest, EachReaderOfASocketGetsTheLinesSinceItCame) {
  LineStream stream(SocketTarget());
  stream.Write("nobody reads this");
  Reader first(Socket());
  stream.Write("one");
  Reader second(Socket());
  stream.Write("two");
  EXPECT_EQ(first.Read(), "one\ntwo\n");
  EXPECT_EQ(second.Read(), "two\n");
}

TEST_F(LineStreamTest, AReaderThatGoesAwayLeavesTheOthers) {
  LineStream stream(SocketTarget());
  Reader stays(Socket());
  std::optional<Reader> goes(Socket());
  stream.Write("one");
  goes.reset();
  for (int i = 0; i < 3; ++i) stream.Write("more");
  EXPECT_EQ(stays.Read(), "one\nmore\nmore\nmore\n");
}

// It is left once its buffer is full, and never gets a part of a line; the run does not wait.
TEST_F(LineStreamTest, AReaderThatDoesNotReadIsLeft) {
  LineStream stream(SocketTarget());
  Reader reads(Socket());
  Reader idle(Socket());
  const std::string line(10'000, 'x');
  constexpr std::size_t kLines = 300;  // 3 MB: more than any socket's buffer.
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < kLines; ++i) {
    stream.Write(line);
    bytes += reads.Read()->size();
  }
  EXPECT_EQ(bytes, kLines * (line.size() + 1));
  const std::string held = *idle.Read();
  EXPECT_GT(held.size(), 0u);
  EXPECT_LT(held.size(), bytes);
  EXPECT_FALSE(idle.Read()) << "closed by the other end";
}

TEST_F(LineStreamTest, TheSocketIsGoneWithItsStream) {
  std::optional<LineStream> stream(SocketTarget());
  EXPECT_TRUE(fs::is_socket(Socket()));
  Reader reader(Socket());
  stream->Write("one");
  stream.reset();
  EXPECT_FALSE(fs::exists(Socket()));
  EXPECT_EQ(reader.Read(), "one\n");
  EXPECT_FALSE(reader.Read());
}

// As a run leaves it that was killed.
TEST_F(LineStreamTest, ASocketThatIsLeftOverIsReplaced) {
  const int killed = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, Socket().c_str());
  ASSERT_EQ(bind(killed, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  close(killed);
  ASSERT_TRUE(fs::is_socket(Socket()));
  LineStream stream(SocketTarget());
  Reader reader(Socket());
  stream.Write("one");
  EXPECT_EQ(reader.Read(), "one\n");
}

TEST_F(LineStreamTest, ASocketInUseIsRefusedAndStays) {
  LineStream stream(SocketTarget());
  EXPECT_THAT(Refusal(SocketTarget()),
              AllOf(HasSubstr(SocketTarget()), HasSubstr("another program listens there")));
  Reader reader(Socket());
  stream.Write("one");
  EXPECT_EQ(reader.Read(), "one\n");
}

TEST_F(LineStreamTest, AFileIsNeverReplacedByASocket) {
  const fs::path file = folder_.Write("light.socket", "mine");
  EXPECT_THAT(Refusal(SocketTarget()), HasSubstr("expected a socket or nothing, found a file"));
  EXPECT_EQ(ContentOf(file), "mine");
}

TEST_F(LineStreamTest, RefusesPathsThatNoSocketCanHave) {
  EXPECT_THAT(Refusal("unix:"), HasSubstr("expected a path of 1 to 107 bytes"));
  EXPECT_THAT(Refusal("unix:/" + std::string(120, 'x')), HasSubstr("1 to 107 bytes"));
  EXPECT_THAT(Refusal("unix:/no/such/folder/socket"), HasSubstr("No such file"));
  EXPECT_THAT(Refusal("/no/such/folder/file"), HasSubstr("expected a file or pipe"));
}

}  // namespace
}  // namespace pleinair::line_stream_test
