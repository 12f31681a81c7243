// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/keystore.hpp"

#include <openssl/bn.h>
#include <openssl/err.h>
#include <openssl/x509v3.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <utility>

#include "tandem/runtime/names.hpp"
#include "tandem/runtime/openssl.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

using rt::openssl::Bio;
using rt::openssl::Certificate;
using rt::openssl::Key;
using rt::openssl::text_of;
using Number = std::unique_ptr<BIGNUM, rt::openssl::Free<BN_free>>;
using Extension = std::unique_ptr<X509_EXTENSION, rt::openssl::Free<X509_EXTENSION_free>>;

struct Identity {
  Key key;
  Certificate certificate;
};

// Returns OpenSSL's result or throws its error.
template <class T>
T require(T value, const std::string& what) {
  if (value) return value;
  char reason[256];
  ERR_error_string_n(ERR_get_error(), reason, sizeof reason);
  throw std::runtime_error(what + ": " + reason);
}

[[noreturn]] void fail(const fs::path& file) {
  throw std::runtime_error(file.string() + ": " + std::strerror(errno));
}

constexpr mode_t kSecret = 0600, kPublic = 0644;

// Atomic: a process starting meanwhile reads either the old file or the new one.
void write_file(const fs::path& file, const std::string& text, mode_t mode) {
  const fs::path fresh = file.string() + ".new";
  fs::remove(fresh);
  const int descriptor = open(fresh.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (descriptor < 0) fail(fresh);
  const ssize_t written = write(descriptor, text.data(), text.size());
  if (close(descriptor) != 0 || written != static_cast<ssize_t>(text.size())) fail(fresh);
  fs::rename(fresh, file);
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error(folder.string() + ": " + error.message());
}

void make_link(const fs::path& target, const fs::path& link) {
  fs::remove(link);
  fs::create_symlink(fs::relative(target, link.parent_path()), link);
}

std::string pem_of(EVP_PKEY& key) {
  const Bio bio{BIO_new(BIO_s_mem())};
  require(PEM_write_bio_PKCS8PrivateKey(bio.get(), &key, nullptr, nullptr, 0, nullptr, nullptr),
          "cannot encode a key");
  return text_of(*bio);
}

std::string pem_of(X509& certificate) {
  const Bio bio{BIO_new(BIO_s_mem())};
  require(PEM_write_bio_X509(bio.get(), &certificate), "cannot encode a certificate");
  return text_of(*bio);
}

Certificate read_certificate(const fs::path& file) {
  return require(rt::openssl::read_certificate(file), file.string());
}

Identity read_identity(const fs::path& certificate, const fs::path& key) {
  return {require(rt::openssl::read_key(key), key.string()), read_certificate(certificate)};
}

void write_identity(const Identity& identity, const fs::path& certificate, const fs::path& key) {
  write_file(key, pem_of(*identity.key), kSecret);
  write_file(certificate, pem_of(*identity.certificate), kPublic);
}

void set_random_serial(X509& certificate) {
  constexpr int kBits = 159;  // positive in at most 20 octets, the limit for serial numbers
  const Number number{BN_new()};
  require(BN_rand(number.get(), kBits, BN_RAND_TOP_ANY, BN_RAND_BOTTOM_ANY),
          "cannot generate a random number");
  BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(&certificate));
}

void set_subject(X509& certificate, const std::string& common_name) {
  require(X509_NAME_add_entry_by_txt(X509_get_subject_name(&certificate), "CN", MBSTRING_UTF8,
                                     reinterpret_cast<const unsigned char*>(common_name.data()),
                                     static_cast<int>(common_name.size()), -1, 0),
          "cannot create a certificate for " + common_name);
}

void set_constraints(X509& certificate, const char* constraints) {
  const Extension extension{require(
      X509V3_EXT_conf_nid(nullptr, nullptr, NID_basic_constraints, constraints), constraints)};
  X509_add_ext(&certificate, extension.get(), -1);
}

// Without an authority the certificate is self-signed and may act as an authority.
Identity make_identity(const std::string& common_name, const Validity& validity,
                       const Identity* authority) {
  Identity made{
      Key{require(EVP_PKEY_Q_keygen(nullptr, nullptr, "EC", "P-256"), "cannot generate a key")},
      Certificate{require(X509_new(), "cannot create a certificate")}};
  X509& certificate = *made.certificate;
  constexpr long kVersion3 = 2;
  X509_set_version(&certificate, kVersion3);
  set_random_serial(certificate);
  ASN1_TIME_set(X509_getm_notBefore(&certificate), validity.from);
  ASN1_TIME_set(X509_getm_notAfter(&certificate), validity.until);
  X509_set_pubkey(&certificate, made.key.get());
  set_subject(certificate, common_name);
  const Identity& issuer = authority == nullptr ? made : *authority;
  X509_set_issuer_name(&certificate, X509_get_subject_name(issuer.certificate.get()));
  set_constraints(certificate, authority == nullptr ? "critical,CA:TRUE,pathlen:1" : "CA:FALSE");
  require(X509_sign(&certificate, issuer.key.get(), EVP_sha256()), "cannot sign a certificate");
  return made;
}

// S/MIME: the document in clear text, followed by its signature.
std::string signed_document(const std::string& document, const Identity& authority) {
  constexpr int kFlags = PKCS7_DETACHED | PKCS7_TEXT;
  const auto input = [&] {
    return Bio{BIO_new_mem_buf(document.data(), static_cast<int>(document.size()))};
  };
  const Bio to_sign = input(), to_copy = input(), output{BIO_new(BIO_s_mem())};
  const rt::openssl::Signature signature{require(
      PKCS7_sign(authority.certificate.get(), authority.key.get(), nullptr, to_sign.get(), kFlags),
      "cannot sign a document")};
  require(SMIME_write_PKCS7(output.get(), signature.get(), to_copy.get(), kFlags),
          "cannot encode a signature");
  return text_of(*output);
}

// Writes the document as name.xml and, signed, as name.p7s.
void write_document(const fs::path& folder, const char* name, const std::string& document,
                    const Identity& authority) {
  write_file(folder / (std::string{name} + ".xml"), document, kPublic);
  write_file(folder / (std::string{name} + ".p7s"), signed_document(document, authority), kPublic);
}

fs::path public_file(const fs::path& keystore, const char* authority) {
  return keystore / "public" / (std::string{authority} + "_ca.cert.pem");
}
fs::path private_file(const fs::path& keystore, const char* authority) {
  return keystore / "private" / (std::string{authority} + "_ca.key.pem");
}
constexpr const char* kAuthorities[] = {"identity", "permissions"};

Identity read_authority(const fs::path& keystore, const char* authority) {
  return read_identity(public_file(keystore, authority), private_file(keystore, authority));
}

bool has_authorities(const fs::path& keystore) {
  for (const char* authority : kAuthorities)
    if (!fs::exists(public_file(keystore, authority)) ||
        !fs::exists(private_file(keystore, authority)))
      return false;
  return true;
}

void make_authorities(const fs::path& keystore) {
  const fs::path certificate = keystore / "public" / "ca.cert.pem";
  const fs::path key = keystore / "private" / "ca.key.pem";
  write_identity(make_identity("tandemCA", usual_validity(), nullptr), certificate, key);
  for (const char* authority : kAuthorities) {
    make_link(certificate, public_file(keystore, authority));
    make_link(key, private_file(keystore, authority));
  }
}

// Whether the authority signed the certificate and it is valid now.
bool is_good(X509& certificate, const Identity& authority) {
  return X509_verify(&certificate, authority.key.get()) == 1 &&
         rt::openssl::age_of(certificate) == 0;
}

std::time_t seconds_of(const ASN1_TIME* time) {
  std::tm parts{};
  require(ASN1_TIME_to_tm(time, &parts), "invalid time in a certificate");
  return timegm(&parts);
}

// Keeps or creates the folder's identity. Returns its validity period, which its permissions share.
Validity provide_identity(const fs::path& folder, const std::string& enclave,
                          const Identity& authority, const Validity& validity) {
  const fs::path certificate = folder / "cert.pem", key = folder / "key.pem";
  const bool there = fs::exists(certificate) && fs::exists(key);
  if (!there || !is_good(*read_certificate(certificate), authority))
    write_identity(make_identity(enclave, validity, &authority), certificate, key);
  const Certificate read = read_certificate(certificate);
  return {seconds_of(X509_get0_notBefore(read.get())), seconds_of(X509_get0_notAfter(read.get()))};
}

}  // namespace

Validity usual_validity() {
  constexpr std::time_t kDay = 86400;
  const std::time_t now = std::time(nullptr);
  return {now - kDay, now + 3650 * kDay};
}

void create_keystore(const fs::path& keystore, int domain) {
  for (const char* folder : {"public", "private", "enclaves"}) make_folder(keystore / folder);
  fs::permissions(keystore / "private", fs::perms::owner_all);
  if (!has_authorities(keystore)) make_authorities(keystore);
  const fs::path enclaves = keystore / "enclaves";
  if (!fs::exists(enclaves / "governance.p7s"))
    write_document(enclaves, "governance", governance_document(domain),
                   read_authority(keystore, "permissions"));
}

void create_enclave(const fs::path& keystore, const std::string& enclave,
                    const Permissions& permissions, int domain, const Validity& validity) {
  if (!rt::is_full_name(enclave))
    throw std::invalid_argument("'" + enclave + "' is not an enclave name; write /a or /a/b");
  const fs::path folder = keystore / "enclaves" / enclave.substr(1);
  make_folder(folder);
  for (const char* authority : kAuthorities) {
    const fs::path certificate = public_file(keystore, authority);
    make_link(certificate, folder / certificate.filename());
  }
  make_link(keystore / "enclaves" / "governance.p7s", folder / "governance.p7s");
  const Identity identity_authority = read_authority(keystore, "identity");
  const Validity holds = provide_identity(folder, enclave, identity_authority, validity);
  write_document(folder, "permissions", permissions_document(enclave, permissions, holds, domain),
                 read_authority(keystore, "permissions"));
}

}  // namespace tandem
