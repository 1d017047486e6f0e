//! Writes all generated files of the design that it is compiled for to stdout, as JSON.

fn main() {
    let files = hoverlock_rtl::emission::files().map_err(|error| error.to_string());
    match files.and_then(|files| serde_json::to_string(&files).map_err(|error| error.to_string())) {
        Ok(text) => println!("{text}"),
        Err(error) => {
            eprintln!("error: {error}");
            std::process::exit(2);
        }
    }
}
