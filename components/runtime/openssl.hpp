// SPDX-License-Identifier: Apache-2.0
// RAII wrappers for OpenSSL objects, and functions that read them from files.
#pragma once

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>

#include <filesystem>
#include <memory>
#include <string>

namespace tandem::runtime::openssl {

template <auto free_it>
struct Free {
  template <class T>
  void operator()(T* object) const {
    free_it(object);
  }
};
using Bio = std::unique_ptr<BIO, Free<BIO_free_all>>;
using Certificate = std::unique_ptr<X509, Free<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;
using Signature = std::unique_ptr<PKCS7, Free<PKCS7_free>>;

/// Both readers return null if the file cannot be read or does not contain the object.
[[nodiscard]] inline Certificate read_certificate(const std::filesystem::path& file) {
  const Bio bio{BIO_new_file(file.c_str(), "r")};
  return Certificate{bio ? PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr) : nullptr};
}
[[nodiscard]] inline Key read_key(const std::filesystem::path& file) {
  const Bio bio{BIO_new_file(file.c_str(), "r")};
  return Key{bio ? PEM_read_bio_PrivateKey(bio.get(), nullptr, nullptr, nullptr) : nullptr};
}

/// The contents of a memory BIO.
[[nodiscard]] inline std::string text_of(BIO& bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(&bio, &data);
  return {data, static_cast<std::size_t>(size)};
}

/// Validity of the certificate now: -1 not yet valid, 0 valid, 1 expired.
[[nodiscard]] inline int age_of(const X509& certificate) {
  if (X509_cmp_current_time(X509_get0_notBefore(&certificate)) > 0) return -1;
  return X509_cmp_current_time(X509_get0_notAfter(&certificate)) < 0 ? 1 : 0;
}

}  // namespace tandem::runtime::openssl
