// SPDX-License-Identifier: MIT
// Certificates made by code, for tests of TLS.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

namespace limn {

// A key pair and its certificate, for 127.0.0.1 and localhost.
struct TestIdentity {
  // PEM.
  std::string certificate;
  std::string key;
};

// An authority that signs certificates. Elliptic curve P-256; valid for a day.
class TestAuthority {
 public:
  explicit TestAuthority(const std::string& name);
  ~TestAuthority();

  // PEM.
  const std::string& certificate() const { return pem_; }
  // valid_seconds: from now; negative for one that has expired already.
  TestIdentity Issue(const std::string& name, long valid_seconds = 3600) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::string pem_;
};

// A directory of its own that is removed at the end.
class TestDirectory {
 public:
  TestDirectory();
  ~TestDirectory();
  std::string path(const std::string& name) const { return (root_ / name).string(); }
  // Whole or not at all, as certificates are renewed. Returns the path.
  std::string Write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path root_;
};

}  // namespace limn
