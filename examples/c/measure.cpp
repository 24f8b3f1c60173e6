// SPDX-License-Identifier: Apache-2.0
// Measures the brightness of an image for several f-numbers or other values of a parameter:
//
//     measure SCENE.gltf PATH VALUE... [--device DEVICE]
//
// The library has C functions; here each handle is owned by a std::unique_ptr, and a failure is an
// exception with the library's sentence.
#include <mcvisi/mcvisi.h>

#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

template <typename T, void (*Free)(T *)> struct Deleter {
    void operator()(T *handle) const { Free(handle); }
};
using Session = std::unique_ptr<mcv_session, Deleter<mcv_session, mcv_session_close>>;
using Rig = std::unique_ptr<mcv_rig, Deleter<mcv_rig, mcv_rig_free>>;
using Picture = std::unique_ptr<mcv_picture, Deleter<mcv_picture, mcv_picture_free>>;
using Text = std::unique_ptr<char, Deleter<char, mcv_text_free>>;

// Calls a function with the arguments and an mcv_error at its end.
template <typename Function, typename... Arguments>
void call(Function function, Arguments... arguments) {
    mcv_error error = {""};
    if (function(arguments..., &error) != MCV_OK) throw std::runtime_error(error.text);
}

static void measure(const Session &session, const Rig &rig, const char *path, const char *value) {
    mcv_picture *image = nullptr;
    char *report = nullptr;
    call(mcv_rig_set, rig.get(), path, value);
    call(mcv_session_render, session.get(), rig.get(), "{\"spp\": 16, \"resolution\": [96, 64]}",
         nullptr, nullptr, &image, nullptr);
    const Picture owned(image);
    call(mcv_picture_measure, image, nullptr, nullptr, "{\"region\": \"all=0,0,96,64\"}", &report);
    const Text text(report);
    std::cout << path << " = " << value << ": " << report << '\n';
}

int main(int argc, char **argv) {
    const bool chosen = argc > 3 && std::string(argv[argc - 2]) == "--device";
    const std::string options =
        chosen ? std::string(R"({"device": ")") + argv[argc - 1] + "\"}" : "";
    const int end = chosen ? argc - 2 : argc;
    if (end < 4) {
        std::cerr << "usage: measure SCENE.gltf PATH VALUE... [--device DEVICE]\n";
        return MCV_USAGE;
    }
    try {
        mcv_session *session = nullptr;
        mcv_rig *rig = nullptr;
        call(mcv_session_open, options.c_str(), &session);
        const Session owned_session(session);
        call(mcv_rig_open, argv[1], &rig);
        const Rig owned_rig(rig);
        for (int i = 3; i < end; ++i) measure(owned_session, owned_rig, argv[2], argv[i]);
    } catch (const std::exception &failure) {
        std::cerr << failure.what() << '\n';
        return MCV_FAILED;
    }
}
