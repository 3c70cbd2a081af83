# docker build -t unit5 . && docker run -it --network host unit5
FROM debian:12
COPY . /unit5
WORKDIR /unit5
RUN script/setup
CMD ["script/demo"]
