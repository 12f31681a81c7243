// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/security_fault.hpp"

#include "tandem/runtime/openssl.hpp"

namespace tandem::runtime {
namespace {

namespace fs = std::filesystem;
using namespace openssl;

struct FreeStack {
  void operator()(STACK_OF(X509) * stack) const { sk_X509_free(stack); }
};

std::string certificate_fault(const fs::path& folder) {
  const auto certificate = read_certificate(folder / "cert.pem");
  const auto authority = read_certificate(folder / "identity_ca.cert.pem");
  const auto key = read_key(folder / "key.pem");
  if (!certificate) return "cert.pem is not a certificate";
  if (!authority) return "identity_ca.cert.pem is not a certificate";
  if (!key) return "key.pem is not a key";
  if (X509_check_private_key(certificate.get(), key.get()) != 1)
    return "key.pem is not the key of cert.pem";
  if (X509_verify(certificate.get(), X509_get0_pubkey(authority.get())) != 1)
    return "cert.pem was not signed by identity_ca.cert.pem";
  const int age = age_of(*certificate);
  if (age != 0) return age > 0 ? "cert.pem has expired" : "cert.pem is not valid yet";
  return {};
}

// Returns the signed text, or an empty string if the authority's signature is not valid for it.
std::string signed_text(const fs::path& document, X509& authority) {
  const Bio file{BIO_new_file(document.c_str(), "r")};
  if (!file) return {};
  BIO* raw = nullptr;
  const Signature signature{SMIME_read_PKCS7(file.get(), &raw)};
  const Bio content{raw}, text{BIO_new(BIO_s_mem())};
  const std::unique_ptr<STACK_OF(X509), FreeStack> signers{sk_X509_new_null()};
  if (!signature || !signers || sk_X509_push(signers.get(), &authority) == 0) return {};
  constexpr int kFlags = PKCS7_TEXT | PKCS7_NOVERIFY | PKCS7_NOINTERN;
  const bool good =
      PKCS7_verify(signature.get(), signers.get(), nullptr, content.get(), text.get(), kFlags) == 1;
  return good ? text_of(*text) : "";
}

std::string document_fault(const fs::path& folder) {
  const auto authority = read_certificate(folder / "permissions_ca.cert.pem");
  const auto certificate = read_certificate(folder / "cert.pem");
  if (!authority) return "permissions_ca.cert.pem is not a certificate";
  for (const char* name : {"governance.p7s", "permissions.p7s"}) {
    const std::string text = signed_text(folder / name, *authority);
    if (text.empty())
      return std::string{name} +
             " was changed after it was signed, or was not signed by permissions_ca.cert.pem";
    char subject[256] = {};
    X509_NAME_get_text_by_NID(X509_get_subject_name(certificate.get()), NID_commonName, subject,
                              sizeof subject);
    const bool of_enclave = std::string{name} == "permissions.p7s";
    if (of_enclave && text.find(std::string{"CN="} + subject) == std::string::npos)
      return std::string{name} + " are not for " + subject + ", the subject of cert.pem";
  }
  return {};
}

}  // namespace

std::string security_fault(const std::string& folder) {
  const std::string fault = certificate_fault(folder);
  return fault.empty() ? document_fault(folder) : fault;
}

}  // namespace tandem::runtime
