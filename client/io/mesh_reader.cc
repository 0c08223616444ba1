// SPDX-License-Identifier: MIT
// Reads a file into memory and hands it to the reader of its extension.
#include "client/io/mesh_reader.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client/io/mesh_collector.h"
#include "engine/base/buffer.h"
#include "engine/base/error.h"

namespace limn {
namespace {

using ReadFunction = absl::Status (*)(std::string_view bytes, io::MeshCollector* collector);

struct Format {
  std::string_view extension;
  ReadFunction read;
};

constexpr std::array kFormats = {Format{".obj", io::ReadObj}, Format{".off", io::ReadOff},
                                 Format{".ply", io::ReadPly}, Format{".stl", io::ReadStl}};

// A file descriptor that is closed at the end.
class InputFile {
 public:
  explicit InputFile(const std::string& path)
      : descriptor_(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  ~InputFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

absl::Status SystemError(const std::string& path) {
  return absl::ErrnoToStatus(errno, absl::StrCat("cannot read ", path));
}

absl::Status NotRegular(const std::string& path) {
  return MakeError(absl::StrCat(path, " is not a regular file"),
                   {.reason = Reason::kMalformedFile,
                    .field = "file",
                    .remedy = "Save the mesh to a file and name that"});
}

absl::StatusOr<Buffer<char>> ReadBytes(const std::string& path) {
  const InputFile file(path);
  if (file.descriptor() < 0) return SystemError(path);
  struct stat info = {};
  if (fstat(file.descriptor(), &info) != 0) return SystemError(path);
  if (!S_ISREG(info.st_mode)) return NotRegular(path);
  Buffer<char> bytes(static_cast<std::size_t>(info.st_size));
  std::size_t have = 0;
  while (have < bytes.size()) {
    const ssize_t got = read(file.descriptor(), bytes.data() + have, bytes.size() - have);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return SystemError(path);
    if (got == 0) break;  // it has become shorter
    have += static_cast<std::size_t>(got);
  }
  bytes.resize(have);
  return bytes;
}

absl::StatusOr<PolygonMesh> Read(const std::string& path) {
  const std::filesystem::path name(path);
  const std::string extension = absl::AsciiStrToLower(name.extension().string());
  for (const Format& format : kFormats) {
    if (format.extension != extension) continue;
    LIMN_ASSIGN_OR_RETURN(const Buffer<char> bytes, ReadBytes(path));
    io::MeshCollector collector(name.filename().string());
    LIMN_RETURN_IF_ERROR(format.read({bytes.data(), bytes.size()}, &collector));
    return collector.Take();
  }
  std::error_code error;
  if (std::filesystem::is_directory(name, error)) return NotRegular(path);
  return MakeError(
      absl::StrCat("mesh files of extension \"", extension, "\" cannot be read: ", path),
      {.reason = Reason::kInvalidOption,
       .field = "file",
       .remedy = "Known extensions are .obj, .off, .ply and .stl"});
}

absl::Status OutOfMemory(const std::string& path) {
  return MakeError(absl::StrCat("no memory to read ", path),
                   {.reason = Reason::kOutOfMemory,
                    .field = "file",
                    .remedy = "Use a machine with more memory or a smaller mesh"});
}

}  // namespace

absl::StatusOr<PolygonMesh> ReadMeshFile(const std::string& path) {
  try {
    return Read(path);
  } catch (const std::bad_alloc&) {
    return OutOfMemory(path);
  } catch (const std::length_error&) {
    return OutOfMemory(path);
  }
}

}  // namespace limn
