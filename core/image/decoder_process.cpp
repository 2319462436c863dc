#include "core/image/decoder_process.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <mutex>
#include <optional>

extern char** environ;

namespace relume {
namespace {

namespace fs = std::filesystem;

#ifdef RELUME_SANITIZED
constexpr rlim_t max_memory_bytes = RLIM_INFINITY;  // it takes terabytes of addresses
#else
constexpr rlim_t max_memory_bytes = rlim_t{4} << 30;
#endif
constexpr rlim_t max_seconds = 60;
constexpr uint32_t max_message_bytes = 1 << 20;  ///< of a header or an error
constexpr size_t most_drained_bytes = size_t{16} << 20;
constexpr size_t max_metadata_bytes = 1 << 18;  ///< longer attributes are left out

/// What a message of the decoder holds.
enum class Reply : uint32_t { header, rows, end, input_error, limit_error };

/// Before each message: `size` bytes follow.
struct Envelope {
  Reply reply = Reply::end;
  uint32_t size = 0;
};

bool send_all(int socket, const void* data, size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t sent = send(socket, at, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    at += sent;
    size -= static_cast<size_t>(sent);
  }
  return true;
}

bool receive_all(int socket, void* data, size_t size) {
  char* at = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t received = recv(socket, at, size, 0);
    if (received < 0 && errno == EINTR) continue;
    if (received <= 0) return false;
    at += received;
    size -= static_cast<size_t>(received);
  }
  return true;
}

/// Numbers and strings one after the other.
class Packer {
 public:
  void add(int number) { bytes_.append(reinterpret_cast<const char*>(&number), sizeof(number)); }
  void add(const std::string& text) {
    add(static_cast<int>(text.size()));
    bytes_ += text;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Takes them out again; what is not there reads as 0 and makes is_right() false.
class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : left_(bytes) {}

  int number() {
    int number = 0;
    if (left_.size() < sizeof(number)) return fail();
    std::memcpy(&number, left_.data(), sizeof(number));
    left_.remove_prefix(sizeof(number));
    return number;
  }
  /// Of things that take at least a number each.
  size_t count() {
    const int count = number();
    if (count < 0 || static_cast<size_t>(count) > left_.size() / sizeof(int)) return fail();
    return static_cast<size_t>(count);
  }
  std::string text() {
    const int size = number();
    if (size < 0 || static_cast<size_t>(size) > left_.size()) {
      fail();
      return {};
    }
    const std::string text(left_.substr(0, static_cast<size_t>(size)));
    left_.remove_prefix(static_cast<size_t>(size));
    return text;
  }
  bool is_right() const { return is_right_ && left_.empty(); }

 private:
  int fail() {
    is_right_ = false;
    left_ = {};
    return 0;
  }

  std::string_view left_;
  bool is_right_ = true;
};

std::string packed(const ImageSpec& spec) {
  Packer packer;
  for (const int number :
       {spec.width, spec.height, spec.x, spec.y, spec.full_width, spec.full_height, spec.full_x,
        spec.full_y, spec.alpha_channel, int{spec.is_bytes}, int{spec.is_srgb}}) {
    packer.add(number);
  }
  packer.add(static_cast<int>(spec.channels.size()));
  for (const std::string& name : spec.channels) packer.add(name);
  std::vector<std::pair<std::string, std::string>> metadata;
  size_t left = max_metadata_bytes;
  for (const auto& entry : spec.metadata) {
    const size_t size = entry.first.size() + entry.second.size();
    if (size > left) continue;
    left -= size;
    metadata.push_back(entry);
  }
  packer.add(static_cast<int>(metadata.size()));
  for (const auto& [name, value] : metadata) {
    packer.add(name);
    packer.add(value);
  }
  return packer.bytes();
}

bool is_sound(const ImageSpec& spec) {
  for (const int size : {spec.width, spec.height, spec.full_width, spec.full_height}) {
    if (size < 1 || size > max_image_px) return false;
  }
  return !spec.channels.empty() && spec.channels.size() <= max_image_channels &&
         spec.alpha_channel >= -1 && spec.alpha_channel < static_cast<int>(spec.channels.size());
}

std::optional<ImageSpec> unpacked(std::string_view bytes) {
  Unpacker unpacker(bytes);
  ImageSpec spec;
  for (int* number : {&spec.width, &spec.height, &spec.x, &spec.y, &spec.full_width,
                      &spec.full_height, &spec.full_x, &spec.full_y, &spec.alpha_channel}) {
    *number = unpacker.number();
  }
  spec.is_bytes = unpacker.number() != 0;
  spec.is_srgb = unpacker.number() != 0;
  spec.channels.resize(unpacker.count());
  for (std::string& name : spec.channels) name = unpacker.text();
  spec.metadata.resize(unpacker.count());
  for (auto& [name, value] : spec.metadata) {
    name = unpacker.text();
    value = unpacker.text();
  }
  if (!unpacker.is_right() || !is_sound(spec)) return std::nullopt;
  return spec;
}

/// The file that this code lies in: a program, or a shared library of ours.
fs::path own_file() {
  Dl_info info{};
  std::error_code code;
  if (dladdr(reinterpret_cast<const void*>(&own_file), &info) != 0 && info.dli_fname != nullptr &&
      info.dli_fname[0] == '/') {
    return fs::canonical(info.dli_fname, code);
  }
  return fs::read_symlink("/proc/self/exe", code);
}

/// Empty where it is not installed.
fs::path find_decoder() {
  fs::path folder = own_file().parent_path();
  for (int level = 0; level < 4; ++level, folder = folder.parent_path()) {
    const fs::path program = folder / "libexec/relume/relume-decode";
    if (access(program.c_str(), X_OK) == 0) return program;
  }
  return {};
}

/// A decoder, and our end of its socket.
class Child {
 public:
  /// Starts one. `source` is what it is for, in errors.
  explicit Child(const ImageSource& source) {
    const fs::path program = find_decoder();
    if (program.empty()) {
      throw source.broken("cannot read the image: the program relume-decode is missing",
                          "install all of Relume, or convert the image to EXR, PNG or JPEG");
    }
    std::array<int, 2> ends{};
    int failure = 0;
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
      failure = errno;
    } else {
      socket_ = ends[0];
      failure = start(program.string(), ends[1]);
      close(ends[1]);
      if (failure == 0) return;
      close(socket_);
    }
    throw source.broken(
        fmt::format("cannot read the image: relume-decode does not start: {}", strerror(failure)),
        "end other programs, or convert the image to EXR, PNG or JPEG");
  }

  ~Child() {
    close(socket_);
    if (id_ < 0 || owner_ != getpid()) return;
    kill(id_, SIGKILL);
    waitpid(id_, nullptr, 0);
  }

  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// False where this is a copy that a fork made.
  bool is_ours() const { return owner_ == getpid(); }

  bool send(const void* data, size_t size) { return send_all(socket_, data, size); }
  bool receive(void* data, size_t size) { return receive_all(socket_, data, size); }

  /// Ends it, unless it has done so, and tells by which signal; 0: by none.
  int end() {
    int status = 0;
    kill(id_, SIGTERM);
    const bool is_known = waitpid(id_, &status, 0) == id_;
    id_ = -1;
    const int signal = is_known && WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    return signal == SIGTERM ? 0 : signal;
  }

 private:
  int start(std::string program, int socket) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, socket, STDIN_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
    const std::array<char*, 2> words = {program.data(), nullptr};
    const int failure =
        posix_spawn(&id_, program.c_str(), &actions, nullptr, words.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failure != 0) id_ = -1;
    return failure;
  }

  pid_t id_ = -1;
  pid_t owner_ = getpid();
  int socket_ = -1;
};

/// A decoder that waits for work: starting one takes a fifth of a second, for its many libraries.
class IdleChild {
 public:
  /// Null where none waits.
  std::unique_ptr<Child> take() {
    const std::scoped_lock lock(mutex_);
    std::unique_ptr<Child> child = std::move(child_);
    return child != nullptr && child->is_ours() ? std::move(child) : nullptr;
  }

  void give_back(std::unique_ptr<Child> child) {
    const std::scoped_lock lock(mutex_);
    child_ = std::move(child);
  }

 private:
  std::mutex mutex_;
  std::unique_ptr<Child> child_;
};

IdleChild& idle_child() {
  static IdleChild child;
  return child;
}

class DecodedInput : public ImageInput {
 public:
  explicit DecodedInput(const ImageSource& source) : source_(source), child_(idle_child().take()) {
    Packer request;
    request.add(fs::absolute(source.path).string());
    request.add(source.place);
    Envelope envelope;
    // One that waited may have been killed meanwhile.
    if (child_ == nullptr || !ask(request.bytes(), envelope)) {
      child_ = std::make_unique<Child>(source);
      if (!ask(request.bytes(), envelope)) fail();
    }
    throw_if_error(envelope);
    const auto spec = unpacked(receive_text(envelope.size));
    if (envelope.reply != Reply::header || !spec) fail();
    spec_ = *spec;
  }

  ~DecodedInput() override {
    constexpr uint8_t no_rows = 0;
    if (child_ == nullptr) return;
    const bool is_idle = has_begun_ ? drain() : child_->send(&no_rows, sizeof(no_rows));
    if (is_idle) idle_child().give_back(std::move(child_));
  }

  void read_rows(const std::function<void(int y, const float* values)>& row) override {
    receive_rows<float>(row);
  }
  void read_rows(const std::function<void(int y, const uint8_t* values)>& row) override {
    receive_rows<uint8_t>(row);
  }

 private:
  template <class Value>
  void receive_rows(const std::function<void(int y, const Value* values)>& row) {
    constexpr uint8_t value_bytes = sizeof(Value);
    has_begun_ = true;
    if (!child_->send(&value_bytes, sizeof(value_bytes))) fail();
    std::vector<Value> values(spec_.row_values());
    for (int y = 0; y < spec_.height; ++y) {
      const Envelope envelope = next();
      if (envelope.reply != Reply::rows || envelope.size != values.size() * sizeof(Value)) fail();
      receive(values.data(), envelope.size);
      row(y, values.data());
    }
    // Its last word may be that the file ended early.
    if (next().reply != Reply::end) fail();
    idle_child().give_back(std::move(child_));
  }

  bool ask(const std::string& request, Envelope& answer) {
    const auto size = static_cast<uint32_t>(request.size());
    return child_->send(&size, sizeof(size)) && child_->send(request.data(), size) &&
           child_->receive(&answer, sizeof(answer));
  }

  void receive(void* data, size_t size) {
    if (!child_->receive(data, size)) fail();
  }

  std::string receive_text(uint32_t size) {
    if (size > max_message_bytes) fail();
    std::string text(size, '\0');
    receive(text.data(), size);
    return text;
  }

  /// The next message's envelope.
  Envelope next() {
    Envelope envelope;
    receive(&envelope, sizeof(envelope));
    throw_if_error(envelope);
    return envelope;
  }

  /// Rows that nobody wants any more, unless it is faster to start another decoder. True: it waits.
  bool drain() {
    std::vector<char> rest(1 << 16);
    Envelope envelope;
    for (size_t drained = 0; drained < most_drained_bytes; drained += envelope.size) {
      if (!child_->receive(&envelope, sizeof(envelope))) return false;
      for (uint32_t left = envelope.size; left > 0;) {
        const auto part = std::min<uint32_t>(left, static_cast<uint32_t>(rest.size()));
        if (!child_->receive(rest.data(), part)) return false;
        left -= part;
      }
      if (envelope.reply != Reply::rows) return true;
    }
    return false;
  }

  /// What the decoder says is wrong.
  void throw_if_error(const Envelope& envelope) {
    if (envelope.reply != Reply::input_error && envelope.reply != Reply::limit_error) return;
    const bool is_limit = envelope.reply == Reply::limit_error;
    const std::string message = printable(receive_text(envelope.size), 900);
    idle_child().give_back(std::move(child_));
    throw Error(is_limit ? ErrorKind::limit : ErrorKind::input, message);
  }

  /// It ended, or sent what makes no sense.
  [[noreturn]] void fail() {
    const int signal = child_->end();
    if (signal == SIGXCPU) {
      throw limit_error(source_.place, "decoding the image takes too long",
                        fmt::format("the limit is {} s of processor time", max_seconds));
    }
    throw source_.unreadable(signal == 0 ? "it cannot be decoded"
                                         : fmt::format("decoding it ended by signal {}", signal));
  }

  ImageSource source_;
  std::unique_ptr<Child> child_;  ///< null after its last word
  bool has_begun_ = false;        ///< with rows
};

void send_message(Reply reply, const void* data, size_t size) {
  const Envelope envelope{reply, static_cast<uint32_t>(size)};
  if (!send_all(STDIN_FILENO, &envelope, sizeof(envelope)) || !send_all(STDIN_FILENO, data, size)) {
    _exit(0);  // nobody listens any more
  }
}

void send_error(Reply reply, std::string_view message) {
  send_message(reply, message.data(), message.size());
}

template <class Value>
void send_rows(ImageInput& input) {
  const size_t size = input.spec().row_values() * sizeof(Value);
  input.read_rows([&](int, const Value* values) { send_message(Reply::rows, values, size); });
  send_message(Reply::end, nullptr, 0);
}

void limit_process() {
  const rlimit memory{max_memory_bytes, max_memory_bytes};
  setrlimit(RLIMIT_AS, &memory);
  const rlimit none{0, 0};
  setrlimit(RLIMIT_FSIZE, &none);
  setrlimit(RLIMIT_CORE, &none);
}

/// Each image has its own share of time.
void limit_time() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  rlimit time{};
  getrlimit(RLIMIT_CPU, &time);
  time.rlim_cur = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) + max_seconds;
  setrlimit(RLIMIT_CPU, &time);
}

void decode(const std::string& path, const std::string& place) {
  try {
    const std::unique_ptr<ImageInput> input = open_image_here({path, place});
    const std::string header = packed(input->spec());
    send_message(Reply::header, header.data(), header.size());
    uint8_t value_bytes = 0;
    if (!receive_all(STDIN_FILENO, &value_bytes, sizeof(value_bytes))) _exit(0);
    if (value_bytes == sizeof(float)) {
      send_rows<float>(*input);
    } else if (value_bytes == sizeof(uint8_t)) {
      send_rows<uint8_t>(*input);
    }
  } catch (const Error& error) {
    send_error(error.kind() == ErrorKind::limit ? Reply::limit_error : Reply::input_error,
               error.what());
  } catch (const std::bad_alloc&) {
    const Error error =
        limit_error(place, "decoding the image takes too much memory", "the limit is 4 GiB");
    send_error(Reply::limit_error, error.what());
  }
}

}  // namespace

std::unique_ptr<ImageInput> open_in_decoder(const ImageSource& source) {
  return std::make_unique<DecodedInput>(source);
}

int run_decoder() {
  int type = 0;
  socklen_t type_size = sizeof(type);
  if (getsockopt(STDIN_FILENO, SOL_SOCKET, SO_TYPE, &type, &type_size) != 0) {
    fmt::print(stderr, "relume-decode: is started by Relume alone, to read images\n");
    return static_cast<int>(ErrorKind::usage);
  }
  limit_process();
  for (uint32_t size = 0; receive_all(STDIN_FILENO, &size, sizeof(size));) {
    std::string bytes(std::min(size, max_message_bytes), '\0');
    if (!receive_all(STDIN_FILENO, bytes.data(), bytes.size())) break;
    Unpacker request(bytes);
    const std::string path = request.text();
    const std::string place = request.text();
    limit_time();
    decode(path, place);
  }
  return 0;
}

}  // namespace relume
