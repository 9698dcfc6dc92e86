// The page's own elements and the data that dvdx put into it.

export function element<T extends HTMLElement>(id: string, kind: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`the page has no ${kind.name} #${id}`);
  return found;
}

export function dataElements(name: string): HTMLScriptElement[] {
  return [...document.querySelectorAll<HTMLScriptElement>(`script[type="text/x-dvdx-${name}"]`)];
}

// Returns the text of the only data element of this name, and removes the element from the page, because it may be large.
export function takenText(name: string): string | undefined {
  const [found] = dataElements(name);
  const text = found?.textContent ?? undefined;
  found?.remove();
  return text;
}
