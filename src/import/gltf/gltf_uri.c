// SPDX-License-Identifier: MIT
// URIs of buffers and images (2.8): relative paths and embedded data.
#include "import/gltf/gltf.h"

#include <assert.h>
#include <string.h>
#include <strings.h>

bool stp_gltf_uri_is_data(const char* uri)
{
    return strncasecmp(uri, "data:", 5) == 0; // schemes have no case (RFC 3986, 3.1)
}

static int hexadecimal(char c)
{
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

// A percent sign without two hexadecimal digits is kept, because some files never encoded their
// URIs.
static size_t percent_decode(const char* text, size_t length, unsigned char* out)
{
    size_t written = 0;
    for (size_t i = 0; i < length; ++i) {
        bool is_escape = text[i] == '%' && length - i > 2;
        int high = is_escape ? hexadecimal(text[i + 1]) : -1;
        int low = high >= 0 ? hexadecimal(text[i + 2]) : -1;
        if (low >= 0) {
            out[written++] = (unsigned char)(high * 16 + low);
            i += 2;
        } else {
            out[written++] = (unsigned char)text[i];
        }
    }
    assert(written <= length);
    return written;
}

static int base64_digit(char c)
{
    return c >= 'A' && c <= 'Z'   ? c - 'A'
           : c >= 'a' && c <= 'z' ? c - 'a' + 26
           : c >= '0' && c <= '9' ? c - '0' + 52
           : c == '+'             ? 62
           : c == '/'             ? 63
                                  : -1;
}

// False if the text is not base64 (RFC 4648, 4).
static bool base64_decode(const char* text, size_t length, unsigned char* out, size_t* size)
{
    while (length > 0 && text[length - 1] == '=') {
        length -= 1;
    }
    uint32_t bits = 0;
    size_t written = 0;
    for (size_t i = 0; i < length; ++i) {
        int digit = base64_digit(text[i]);
        if (digit < 0) {
            return false;
        }
        bits = bits << 6 | (uint32_t)digit;
        if (i % 4 != 0) {
            out[written++] = (unsigned char)(bits >> (6 - 2 * (i % 4)));
        }
    }
    assert(written <= length);
    *size = written;
    return length % 4 != 1;
}

stp_result stp_gltf_uri_decode(stp_gltf_scope* scope, const char* uri, unsigned char** bytes,
                               size_t* size)
{
    const char* comma = strchr(uri, ',');
    if (comma == NULL) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "the data URI has no comma");
    }
    const char* text = comma + 1;
    size_t length = strlen(text);
    bool is_base64 = comma - uri >= 7 && strncasecmp(comma - 7, ";base64", 7) == 0;
    unsigned char* out = stp_alloc(scope->gltf->context, length + 1);
    if (out == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    if (!is_base64) {
        *size = percent_decode(text, length, out);
    } else if (!base64_decode(text, length, out, size)) {
        stp_free(scope->gltf->context, out);
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "the data URI is not base64");
    }
    *bytes = out;
    return STP_OK;
}

stp_result stp_gltf_uri_path(stp_gltf_scope* scope, const char* uri, char** path)
{
    size_t length = strlen(uri);
    unsigned char* out = stp_alloc(scope->gltf->context, length + 1);
    if (out == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    size_t written = percent_decode(uri, length, out);
    out[written] = '\0';
    if (memchr(out, '\0', written) != NULL) {
        stp_free(scope->gltf->context, out);
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "the URI has a zero byte");
    }
    *path = (char*)out;
    return STP_OK;
}
