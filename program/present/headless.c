// SPDX-License-Identifier: MIT
#include "program/present/headless.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>
#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define EGL_FUNCTIONS(X)                                                                           \
    X(PFNEGLGETPROCADDRESSPROC, eglGetProcAddress)                                                 \
    X(PFNEGLINITIALIZEPROC, eglInitialize)                                                         \
    X(PFNEGLBINDAPIPROC, eglBindAPI)                                                               \
    X(PFNEGLCREATECONTEXTPROC, eglCreateContext)                                                   \
    X(PFNEGLDESTROYCONTEXTPROC, eglDestroyContext)                                                 \
    X(PFNEGLMAKECURRENTPROC, eglMakeCurrent)

enum { DEVICES_MAX = 16 };

typedef struct egl {
#define X(type, name) type name;
    EGL_FUNCTIONS(X)
#undef X
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display;
    PFNEGLQUERYDEVICESEXTPROC query_devices;     ///< NULL: devices cannot be listed
    PFNEGLQUERYDEVICESTRINGEXTPROC query_device; ///< NULL: devices cannot be described
} egl;

static bool find_functions(void* library, egl* e)
{
#define X(type, name)                                                                              \
    *(void**)&e->name = dlsym(library, #name);                                                     \
    if (e->name == NULL) {                                                                         \
        return false;                                                                              \
    }
    EGL_FUNCTIONS(X)
#undef X
    e->get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)e->eglGetProcAddress("eglGetPlatformDisplayEXT");
    e->query_devices = (PFNEGLQUERYDEVICESEXTPROC)e->eglGetProcAddress("eglQueryDevicesEXT");
    e->query_device =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)e->eglGetProcAddress("eglQueryDeviceStringEXT");
    return e->get_display != NULL;
}

/// Whether a device name belongs to a software renderer.
static bool is_software_name(const char* name)
{
    static const char* const names[] = {"llvmpipe", "softpipe", "swrast", "SwiftShader",
                                        "Software"};
    bool software = false;
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); ++i) {
        software = software || strstr(name, names[i]) != NULL;
    }
    return software;
}

/// Whether a device is Mesa's software renderer. Creating a context on it would tell the same, but
/// takes longer than a small picture. Its drivers for WSL and by variable can use a GPU.
/// LeakSanitizer crashes at exit if the first context of Mesa is not discarded, as seen in version
/// 14 ("Tracer caught signal 11").
static bool is_software_device(const egl* e, EGLDeviceEXT device)
{
#if defined(STP_SANITIZED)
    const bool may_ask = false;
#else
    const bool may_ask = true;
#endif
    const char* extensions = NULL;
    if (may_ask && e->query_device != NULL && getenv("GALLIUM_DRIVER") == NULL &&
        access("/dev/dxg", F_OK) != 0) {
        extensions = e->query_device(device, EGL_EXTENSIONS);
    }
    return extensions != NULL && strstr(extensions, "EGL_MESA_device_software") != NULL;
}

/// Lists the devices that may be a GPU (or all); returns false if devices cannot be listed.
static bool list_devices(const egl* e, bool software, EGLDeviceEXT* devices, EGLint* count)
{
    EGLint all = 0;
    *count = 0;
    if (e->query_devices == NULL || !e->query_devices(DEVICES_MAX, devices, &all) || all == 0) {
        return false;
    }
    for (EGLint i = 0; i < all; ++i) {
        if (software || !is_software_device(e, devices[i])) {
            devices[(*count)++] = devices[i];
        }
    }
    return true;
}

/// Contexts report their loss only on request.
static bool make_current(const egl* e, const stp_headless_desc* desc, bool tells_loss,
                         stp_headless* headless)
{
    const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION,
                             4,
                             EGL_CONTEXT_MINOR_VERSION,
                             5,
                             EGL_CONTEXT_OPENGL_PROFILE_MASK,
                             EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                             EGL_CONTEXT_OPENGL_DEBUG,
                             desc->debug ? EGL_TRUE : EGL_FALSE,
                             tells_loss ? EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY : EGL_NONE,
                             EGL_LOSE_CONTEXT_ON_RESET,
                             EGL_NONE};
    e->eglBindAPI(EGL_OPENGL_API);
    headless->context =
        e->eglCreateContext(headless->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
    return headless->context != EGL_NO_CONTEXT &&
           e->eglMakeCurrent(headless->display, EGL_NO_SURFACE, EGL_NO_SURFACE, headless->context);
}

static void release_context(const egl* e, stp_headless* headless)
{
    if (headless->display != EGL_NO_DISPLAY) {
        e->eglMakeCurrent(headless->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (headless->context != EGL_NO_CONTEXT) {
            e->eglDestroyContext(headless->display, headless->context);
        }
        // keep the display open: terminating it would unload the driver, which would leak its state
    }
    headless->display = EGL_NO_DISPLAY;
    headless->context = EGL_NO_CONTEXT;
}

/// Creates a context on one display, if it is of the wanted kind.
static bool try_display(const egl* e, const stp_headless_desc* desc, EGLenum platform, void* native,
                        stp_headless* headless)
{
    headless->display = e->get_display(platform, native, NULL);
    if (headless->display == EGL_NO_DISPLAY || !e->eglInitialize(headless->display, NULL, NULL)) {
        headless->display = EGL_NO_DISPLAY;
        return false;
    }
    PFNGLGETSTRINGPROC get_string = (PFNGLGETSTRINGPROC)e->eglGetProcAddress("glGetString");
    if (get_string == NULL ||
        !(make_current(e, desc, true, headless) || make_current(e, desc, false, headless))) {
        release_context(e, headless);
        return false;
    }
    const GLubyte* name = get_string(GL_RENDERER);
    snprintf(headless->device, sizeof(headless->device), "%s",
             name != NULL ? (const char*)name : "");
    headless->is_software = is_software_name(headless->device);
    if ((desc->software && !headless->is_software) ||
        (desc->only_hardware && headless->is_software)) {
        release_context(e, headless);
        return false;
    }
    return true;
}

/// Creates a context on the first hardware (or software) device that supports it.
static bool try_devices(const egl* e, const stp_headless_desc* desc, bool software,
                        stp_headless* headless)
{
    EGLDeviceEXT devices[DEVICES_MAX];
    EGLint count;
    stp_headless_desc kind = *desc;
    kind.software = software;
    kind.only_hardware = !software;
    list_devices(e, software, devices, &count);
    for (EGLint i = 0; i < count; ++i) {
        if (try_display(e, &kind, EGL_PLATFORM_DEVICE_EXT, devices[i], headless)) {
            return true;
        }
    }
    return false;
}

/// Whether anything but Mesa's software renderer may be there.
static bool may_have_gpu(const egl* e)
{
    EGLDeviceEXT devices[DEVICES_MAX];
    EGLint count;
    return !list_devices(e, false, devices, &count) || count > 0;
}

const char* stp_headless_create(const stp_headless_desc* desc, stp_headless* headless)
{
    egl e;
    *headless = (stp_headless){0};
    // never closed: drivers do not survive unloading
    headless->library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (headless->library == NULL) {
        return "libEGL.so.1 was not found (Debian: libegl1)";
    }
    if (!find_functions(headless->library, &e)) {
        return "libEGL.so.1 lacks functions of EGL 1.5";
    }
    headless->get_proc_address = e.eglGetProcAddress;
    bool made = !desc->software && try_devices(&e, desc, false, headless);
    made = made ||
           ((!desc->only_hardware || may_have_gpu(&e)) &&
            try_display(&e, desc, EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, headless));
    made = made || (!desc->only_hardware && try_devices(&e, desc, true, headless));
    if (made) {
        return NULL;
    }
    return desc->only_hardware ? "no GPU offers OpenGL 4.5 without a window"
                               : "no device offers OpenGL 4.5 without a window (Debian: "
                                 "libgl1-mesa-dri renders on the CPU)";
}

void stp_headless_destroy(stp_headless* headless)
{
    egl e;
    if (headless->library != NULL && find_functions(headless->library, &e)) {
        release_context(&e, headless);
    }
    *headless = (stp_headless){0};
}

void (*stp_headless_get_proc_address(const char* name, void* user))(void)
{
    const stp_headless* headless = user;
    return headless->get_proc_address(name);
}
