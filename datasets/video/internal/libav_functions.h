// FFmpeg's functions, loaded when the first video is opened: with FFmpeg come a hundred other
// libraries, which would double the time that every command takes to start.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/crc.h>
#include <libswscale/swscale.h>
}

namespace pleinair {

// The address of a function of one of FFmpeg's libraries, named by its file. Throws
// std::runtime_error, one line: the library is absent, or has no such function.
void* FindLibavFunction(const char* library, const char* function);

// An object that is called as FFmpeg's function of that name. Unqualified calls find it, and not
// the function: nothing of FFmpeg is linked.
#define PLEINAIR_LIBAV_FUNCTION(library, major, name)                                              \
  inline constexpr auto name = [](auto... arguments) {                                             \
    static const auto function = reinterpret_cast<decltype(&::name)>(                              \
        FindLibavFunction("lib" #library ".so." AV_STRINGIFY(LIB##major##_VERSION_MAJOR), #name)); \
    return function(arguments...);                                                                 \
  }
#define PLEINAIR_AVUTIL(name) PLEINAIR_LIBAV_FUNCTION(avutil, AVUTIL, name)
#define PLEINAIR_AVCODEC(name) PLEINAIR_LIBAV_FUNCTION(avcodec, AVCODEC, name)
#define PLEINAIR_AVFORMAT(name) PLEINAIR_LIBAV_FUNCTION(avformat, AVFORMAT, name)
#define PLEINAIR_SWSCALE(name) PLEINAIR_LIBAV_FUNCTION(swscale, SWSCALE, name)

// NOLINTBEGIN(readability-identifier-naming): FFmpeg's names.
PLEINAIR_AVUTIL(av_crc);
PLEINAIR_AVUTIL(av_crc_get_table);
PLEINAIR_AVUTIL(av_d2q);
PLEINAIR_AVUTIL(av_dict_free);
PLEINAIR_AVUTIL(av_dict_get);
PLEINAIR_AVUTIL(av_dict_set);
PLEINAIR_AVUTIL(av_frame_alloc);
PLEINAIR_AVUTIL(av_frame_free);
PLEINAIR_AVUTIL(av_frame_get_buffer);
PLEINAIR_AVUTIL(av_frame_make_writable);
PLEINAIR_AVUTIL(av_log_set_level);
PLEINAIR_AVUTIL(av_rescale);
PLEINAIR_AVUTIL(av_rescale_q);
PLEINAIR_AVUTIL(av_strerror);
PLEINAIR_AVCODEC(av_packet_alloc);
PLEINAIR_AVCODEC(av_packet_free);
PLEINAIR_AVCODEC(av_packet_rescale_ts);
PLEINAIR_AVCODEC(av_packet_unref);
PLEINAIR_AVCODEC(avcodec_alloc_context3);
PLEINAIR_AVCODEC(avcodec_find_encoder);
PLEINAIR_AVCODEC(avcodec_free_context);
PLEINAIR_AVCODEC(avcodec_open2);
PLEINAIR_AVCODEC(avcodec_parameters_from_context);
PLEINAIR_AVCODEC(avcodec_parameters_to_context);
PLEINAIR_AVCODEC(avcodec_receive_frame);
PLEINAIR_AVCODEC(avcodec_receive_packet);
PLEINAIR_AVCODEC(avcodec_send_frame);
PLEINAIR_AVCODEC(avcodec_send_packet);
PLEINAIR_AVFORMAT(av_find_best_stream);
PLEINAIR_AVFORMAT(av_read_frame);
PLEINAIR_AVFORMAT(av_write_frame);
PLEINAIR_AVFORMAT(av_write_trailer);
PLEINAIR_AVFORMAT(avformat_alloc_output_context2);
PLEINAIR_AVFORMAT(avformat_close_input);
PLEINAIR_AVFORMAT(avformat_find_stream_info);
PLEINAIR_AVFORMAT(avformat_free_context);
PLEINAIR_AVFORMAT(avformat_new_stream);
PLEINAIR_AVFORMAT(avformat_open_input);
PLEINAIR_AVFORMAT(avformat_write_header);
PLEINAIR_AVFORMAT(avio_closep);
PLEINAIR_AVFORMAT(avio_flush);
PLEINAIR_AVFORMAT(avio_open);
PLEINAIR_AVFORMAT(avio_seek);
PLEINAIR_SWSCALE(sws_freeContext);
PLEINAIR_SWSCALE(sws_getCachedContext);
PLEINAIR_SWSCALE(sws_getCoefficients);
PLEINAIR_SWSCALE(sws_getContext);
PLEINAIR_SWSCALE(sws_scale);
PLEINAIR_SWSCALE(sws_setColorspaceDetails);
// NOLINTEND(readability-identifier-naming)

#undef PLEINAIR_AVUTIL
#undef PLEINAIR_AVCODEC
#undef PLEINAIR_AVFORMAT
#undef PLEINAIR_SWSCALE
#undef PLEINAIR_LIBAV_FUNCTION

}  // namespace pleinair
